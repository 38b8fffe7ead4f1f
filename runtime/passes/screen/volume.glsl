// The global volume as screen passes read it: binding 4.
layout(set = 0, binding = 4) uniform sampler3D volume;

vec3 volumeSize() {
  return vec3(textureSize(volume, 0));
}

// phi at `p`, both in voxels; outside it is continued.
float volumeAt(vec3 p) {
  vec3 inside = insideLevel(p, volumeSize(), 0);
  return textureLod(volume, inside / volumeSize(), 0.0f).r + distance(p, inside);
}
