#include <cmath>
#include <numbers>

#include "data/make/scatter.h"
#include "data/make/scenes.h"
#include "data/make/stage.h"

namespace overcast {

Scene makeMovingClutter(int objects, std::uint64_t seed) {
  constexpr double kWidth = 4.4, kDepth = 3.6, kHeight = 1.7, kFilled = 0.10;
  Random random{std::mt19937_64(seed)};
  Scene scene = namedScene("clutter_" + std::to_string(objects));
  addGround(scene, kWidth, kDepth, addMaterial(scene, "paper", {0.80, 0.74, 0.66}));
  // Spheres round the objects fill a tenth of the space, whatever their number; a few are no larger than 0.3 m all the same.
  const double radius = std::min(std::cbrt(kFilled * kWidth * kDepth * kHeight * 0.75 / std::numbers::pi / objects), 0.3);
  const ShapeSet shapes = addClutterShapes(scene, random, radius);
  const ScatterRegion region{{-0.5 * kWidth, -0.5 * kDepth}, {0.5 * kWidth, 0.5 * kDepth}, kHeight, 0.5, 0.6, 1.0};
  scatter(scene, random, shapes, region, objects);
  addCamera(scene, {0.9, 3.1, 5.9}, {0.0, 0.48, 0.0}, 37.0);
  return scene;
}

}  // namespace overcast
