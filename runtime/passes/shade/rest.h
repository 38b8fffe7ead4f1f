// Rest: baked visibility, corrected by what the sky estimator says has changed since the bake. Read by C++ and GLSL.
//
// The estimator E errs, but errs alike in what a bake saw and in what a frame shows. So baked visibility V is multiplied by E now over E at
// rest, in the situation of the bake (runtime/rest_visibility.h); what volume, taps, reach and border get wrong in both cancels.
//  * Where V is known as finely as pixels need it, so must be E at rest: it is looked up in a second volume, of all that was there. Where
//    nothing has changed V then stays what was baked, to the bit.
//  * Where vertices are too far apart for V to follow what goes on between them, contact shadows say, E at rest is taken at the vertices
//    too, by the same fit (runtime/rest_fit.h), and what E now has beyond that brings them back. How much V and E are worth there is
//    weighed by what they err.
//  * Objects that were baked alone have E at rest at their vertices as well: a volume for each would be too much.
#ifndef RUNTIME_PASSES_SHADE_REST_H
#define RUNTIME_PASSES_SHADE_REST_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

const int kNoRestValues = -2147483647;

/// Sky visibility at rest of a placed mesh (runtime/rest_visibility.h).
struct RestInstance {
  int shift;    // 0: added to a vertex's index gives that of its value; kNoRestValues: 1 at all
  float trust;  // 4: in apertures, [0, 1], or more (kTrustBeyond), or below 0 (knowingTrust)
};

/// A trust in apertures that is no share: this much where the estimator at rest is looked up in the volume, twice as much where nothing can
/// change.
const float kTrustBeyond = 2.0f;

/// A trust that is a share, in apertures that were baked with others.
OVERCAST_INLINE float knowingTrust(float share) {
  return -1.0f - share;
}
/// Whether the apertures were baked with others.
OVERCAST_INLINE bool restKnowsOthers(float trust) {
  return trust < 0.0f || trust > 1.5f;
}

OVERCAST_INLINE bool restIsLookedUp(float trust) {
  return trust > 1.5f;
}
OVERCAST_INLINE bool restIsUnchanged(float trust) {
  return trust > 3.0f;
}

/// Below this the estimator tells nothing any more.
const float kRestFloor = 0.02f;

/// What is left, [0, 1], where the estimator said `rest` and says `now`: all of what it says where it said 1.
OVERCAST_INLINE float shareLeft(float rest, float now) {
  float least = kRestFloor * (1.0f - rest);
  return clamp((now + least) / (rest + least), 0.0f, 1.0f);
}

/// Sky visibility of a pixel that has `baked`, where the estimator says `now` in place of what it said at `rest`, all in [0, 1]. Above
/// `rest`, what is hidden shrinks as what the estimator hides does. `trust`: the share of that; the rest is the estimator's alone.
OVERCAST_INLINE float correctedVisibility(float baked, float rest, float now, float trust) {
  if (restIsLookedUp(trust)) return baked * now;
  float kept = baked * (now + kRestFloor) / (rest + kRestFloor);
  float freed = 1.0f - (1.0f - baked) * (1.0f + kRestFloor - now) / (1.0f + kRestFloor - rest);
  return mix(now, now < rest ? kept : min(kept, freed), trust < 0.0f ? -1.0f - trust : trust);
}

OVERCAST_SHARED_END

#endif
