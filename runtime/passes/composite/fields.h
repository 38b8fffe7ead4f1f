// Fields: the one storage buffer that holds the texels of all radius and heightfield objects; what x and y are says the kind's header. A
// formula that reads it is written once for C++ and GLSL as
//
//   OVERCAST_INLINE float radiusDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) { ... fields[object.field.x + i] ... }
//   float phi = radiusDistance(OVERCAST_FIELDS_HERE object, local);
//
// In GLSL `fields` is the buffer that composite_bindings.glsl declares, in C++ the array that the caller hands over.
#ifndef RUNTIME_PASSES_COMPOSITE_FIELDS_H
#define RUNTIME_PASSES_COMPOSITE_FIELDS_H

#ifdef __cplusplus
#define OVERCAST_FIELDS const vec2 *fields,
#define OVERCAST_FIELDS_HERE fields,
#else
#define OVERCAST_FIELDS
#define OVERCAST_FIELDS_HERE
#endif

#endif
