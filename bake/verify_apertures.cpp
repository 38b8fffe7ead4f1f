#include "bake/verify_apertures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

constexpr std::uint64_t kVerifySeed = 0x76657266;  // away from those of bakes
/// What a vertex may be off with 256 rays, several times the measured root mean squares (README): radius, direction where all is visible,
/// ambient visibility and transfer. With n rays, sqrt(256 / n) times that.
constexpr double kRadiusNoise = 0.08;
constexpr double kDirectionNoise = 0.12;
constexpr double kAmbientNoise = 0.05;

double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// What is stored of a mesh, besides radius and direction.
struct Kept {
  bool ambient = false;
  bool transfer = false;
};

/// How many times the noise `a` and `b` are apart.
double apart(const ApertureSample& a, const ApertureSample& b, const Kept& kept) {
  double times = std::abs(a.radius - b.radius) / kRadiusNoise;
  // The fewer directions there are to take the mean of, the less it is known; that of none is no direction.
  const double visible = 1.0 - std::cos(std::min(a.radius, b.radius));
  times = std::max(times, visible * angleBetween(a.direction, b.direction) / kDirectionNoise);
  if (kept.ambient) times = std::max(times, std::abs(a.ambient - b.ambient) / kAmbientNoise);
  for (std::size_t i = 0; i < a.transfer.size() && kept.transfer; ++i)
    times = std::max(times, std::abs(a.transfer[i] - b.transfer[i]) / kAmbientNoise);
  return times;
}

ApertureSettings settingsOf(const Mesh& mesh) {
  ApertureSettings settings;
  settings.visibility = {static_cast<int>(mesh.apertureBake->rays), !mesh.visibility->transfer.empty()};
  settings.bits = mesh.visibility->bits;
  settings.errorSamples = mesh.apertureBake->samples;
  settings.seed = mesh.apertureBake->seed;
  return settings;
}

void compare(const char* what, double stated, double measured, std::vector<std::string>& findings) {
  if (std::abs(measured - stated) <= kVerifyApertureTolerance * std::max(measured, stated) + kVerifyApertureSlack) return;
  findings.push_back(fmt::format("states an aperture error of {} {:.6g}, measured {:.6g}", what, stated, measured));
}

std::vector<std::string> checkStated(const Mesh& mesh, const Occluders& occluders) {
  std::vector<std::string> findings;
  const InterpolationError now = measureApertures(mesh, occluders, settingsOf(mesh));
  compare("radius", mesh.apertureBake->radiusError, now.radius, findings);
  compare("direction", mesh.apertureBake->directionError, now.direction, findings);
  if (!mesh.visibility->ambient.empty()) compare("ambient visibility", mesh.apertureBake->ambientError, now.ambient, findings);
  return findings;
}

ApertureSample bakedAt(const VertexVisibility& visibility, std::uint32_t vertex) {
  ApertureSample sample;
  sample.direction = glm::dvec3(visibility.apertures[vertex].direction);
  sample.radius = double{visibility.apertures[vertex].radius};
  sample.ambient = double{visibility.ambient[vertex]};
  for (std::size_t i = 0; i < sample.transfer.size() && !visibility.transfer.empty(); ++i)
    sample.transfer[i] = double{visibility.transfer[vertex][i]};
  return sample;
}

std::vector<std::string> checkVertices(const Mesh& mesh, const Occluders& occluders) {
  const int bakeRays = static_cast<int>(mesh.apertureBake->rays), rays = std::min(std::max(kVerifyRays, 4 * bakeRays), kMostRays);
  const Kept kept{!mesh.visibility->ambient.empty(), !mesh.visibility->transfer.empty()};
  const std::vector<VertexLook> looks = lookAgain(mesh, occluders, {rays, kept.transfer}, kVerifyVertices, kVerifySeed);
  const double most = std::sqrt(256.0 / bakeRays);
  std::vector<VertexLook> off;
  std::copy_if(looks.begin(), looks.end(), std::back_inserter(off),
               [&](const VertexLook& look) { return apart(look.stored, look.seen, kept) > most; });
  if (off.empty()) return {};
  // Fits, and fills of vertices in solids, are far from what is seen there, and right.
  const BakedApertures again = bakeApertures(mesh, occluders, settingsOf(mesh));
  if (again.report.fitted != mesh.apertureBake->fitted) return {};  // on the verge of a fit; the stated errors have been checked
  std::erase_if(off, [&](const VertexLook& look) { return apart(look.stored, bakedAt(again.visibility, look.vertex), kept) <= most; });
  if (off.empty()) return {};
  const VertexLook& worst = *std::max_element(
      off.begin(), off.end(), [&](const auto& a, const auto& b) { return apart(a.stored, a.seen, kept) < apart(b.stored, b.seen, kept); });
  return {
      fmt::format("apertures of {} in {} vertices are not what is seen there; vertex {} states a radius of {:.4f}, seen is {:.4f}, {:.1f}"
                  " degrees from its direction",
                  off.size(), looks.size(), worst.vertex, worst.stored.radius, worst.seen.radius,
                  angleBetween(worst.stored.direction, worst.seen.direction) * 180.0 / std::numbers::pi)};
}

std::vector<std::string> checkMesh(const Scene& scene, const Stage& stage, int index) {
  const Mesh& mesh = scene.meshes[static_cast<std::size_t>(index)];
  const auto others = surroundingsOf(stage, scene, index);
  if (!others) return {message(others.error())};
  const Occluders occluders{stage.trees[static_cast<std::size_t>(index)].get(), others.value().get()};
  std::vector<std::string> findings;
  if (mesh.apertureBake->samples > 0)
    findings = checkStated(mesh, occluders);
  else
    findings.push_back("states no measured error of its apertures");
  std::vector<std::string> vertices = checkVertices(mesh, occluders);
  findings.insert(findings.end(), vertices.begin(), vertices.end());
  return findings;
}

}  // namespace

std::vector<std::string> verifyApertures(const Scene& scene) {
  std::array<std::optional<Result<Stage>>, 2> stages;  // of what occludes itself alone, and of what all at rest occludes
  std::vector<std::string> findings;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (!mesh.visibility) continue;
    const auto add = [&](const std::string& finding) { findings.push_back(fmt::format("mesh {} '{}': {}", i, mesh.name, finding)); };
    if (mesh.visibility->apertures.empty()) add("holds a transfer without apertures");
    if (!mesh.apertureBake) add("says nothing of the bake of its apertures; bake it again");
    if (mesh.visibility->apertures.empty() || !mesh.apertureBake) continue;
    const bool all = mesh.apertureBake->sceneOccludes;
    std::optional<Result<Stage>>& stage = stages[all ? 1 : 0];
    if (!stage) stage.emplace(setStage(scene, all ? Occluding::scene : Occluding::self));
    if (!*stage) return {message(stage->error())};
    for (const std::string& finding : checkMesh(scene, stage->value(), static_cast<int>(i))) add(finding);
  }
  return findings;
}

}  // namespace overcast
