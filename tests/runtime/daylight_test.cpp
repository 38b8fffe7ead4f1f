// Daylight: where the sun is and what colour it and the sky have.
#include "runtime/daylight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

Lighting sunny() {
  Lighting lighting;
  lighting.skyColour = {0.5f, 0.7f, 1.0f};
  lighting.sun = Sun{{0, 1, 0}, {3.0f, 3.0f, 3.0f}, 0.00465f};
  lighting.exposure = 2.0f;
  return lighting;
}

TEST(Daylight, SunRisesInTheEastAndStandsSouthAtNoon) {
  const auto directionAt = [](double hours) { return lightingAt(sunny(), hours).sun->direction; };
  EXPECT_LT(glm::distance(directionAt(6.0), {1, 0, 0}), 1e-6f);
  EXPECT_LT(glm::distance(directionAt(12.0), {0, std::sqrt(0.5f), std::sqrt(0.5f)}), 1e-6f);
  EXPECT_LT(glm::distance(directionAt(18.0), {-1, 0, 0}), 1e-6f);
  EXPECT_LT(glm::distance(directionAt(33.0), directionAt(9.0)), 1e-5f) << "days repeat";
  for (double hours = 0.0; hours < 24.0; hours += 0.1) EXPECT_NEAR(glm::length(directionAt(hours)), 1.0f, 1e-6f);
}

TEST(Daylight, FollowsAnyUp) {
  for (const glm::vec3 up : {glm::vec3(0, 0, 1), glm::vec3(0, 0, -1), glm::normalize(glm::vec3(1, 2, 3))}) {
    Lighting lighting = sunny();
    lighting.up = up;
    EXPECT_NEAR(glm::dot(lightingAt(lighting, 12.0).sun->direction, up), std::sqrt(0.5f), 1e-6f);
    EXPECT_NEAR(glm::dot(lightingAt(lighting, 6.0).sun->direction, up), 0.0f, 1e-6f);
  }
}

TEST(Daylight, ReddensTowardsTheHorizonAndEndsThere) {
  glm::vec3 before = lightingAt(sunny(), 12.0).sun->colour;
  EXPECT_GT(before.x, 2.5f);
  for (double hours = 13.0; hours < 18.0; hours += 0.5) {
    const glm::vec3 colour = lightingAt(sunny(), hours).sun->colour;
    EXPECT_LT(colour.x, before.x);
    EXPECT_LT(colour.z / colour.x, before.z / before.x) << "blue goes first";
    before = colour;
  }
  EXPECT_EQ(lightingAt(sunny(), 18.1).sun->colour, glm::vec3(0.0f));
  EXPECT_EQ(lightingAt(sunny(), 0.0).sun->colour, glm::vec3(0.0f));
}

TEST(Daylight, SkyIsTheScenesByDayRedderAtDuskAndDarkBlueAtNight) {
  EXPECT_EQ(lightingAt(sunny(), 12.0).skyColour, sunny().skyColour);
  const glm::vec3 dusk = lightingAt(sunny(), 17.95).skyColour, night = lightingAt(sunny(), 0.0).skyColour;
  EXPECT_GT(dusk.x / dusk.z, sunny().skyColour.x / sunny().skyColour.z);
  EXPECT_LT(night.x / night.z, sunny().skyColour.x / sunny().skyColour.z);
  EXPECT_LT(night.z, 0.1f * sunny().skyColour.z);
  glm::vec3 last = night;
  for (double hours = 0.0; hours <= 24.0; hours += 1.0 / 60.0) {
    const glm::vec3 sky = lightingAt(sunny(), hours).skyColour;
    EXPECT_LT(glm::distance(sky, last), 0.02f) << "no jump at " << hours;
    last = sky;
  }
}

TEST(Daylight, LeavesTheRestAndGivesASunWhereThereIsNone) {
  Lighting lighting = sunny();
  lighting.sun.reset();
  lighting.areaLights.resize(2);
  const Lighting noon = lightingAt(lighting, 12.0);
  EXPECT_GT(noon.sun->colour.y, 2.0f);
  EXPECT_EQ(noon.areaLights.size(), 2u);
  EXPECT_EQ(noon.exposure, 2.0f);
}

}  // namespace
}  // namespace overcast
