#include "runtime/vulkan/shader.h"

#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <regex>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxShaderBytes = std::uint64_t{4} << 20;
constexpr std::uint32_t kCacheMagic = 0x31534356;  // VCS1
constexpr std::size_t kHashDigits = 32;

/// Texts by path relative to the root. A map, so that hashing goes in one order.
using Sources = std::map<std::string, std::string>;

std::string include(const std::string& name, const std::string& from, const fs::path& root) {
  if (fs::is_regular_file(root / name)) return fs::path(name).lexically_normal().generic_string();
  return (fs::path(from).parent_path() / name).lexically_normal().generic_string();
}

/// Reads `path` and whatever it includes, whether or not the preprocessor will come to that line. What is missing is left for glslang
/// to complain about, which knows the line.
Result<Done> gather(const fs::path& root, const std::string& path, Sources& sources) {
  const Result<std::vector<std::byte>> bytes = readFile(root / path, kMaxShaderBytes);
  if (!bytes) return bytes.error();
  const std::string text(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  sources[path] = text;
  static const std::regex kInclude(R"(^[ \t]*#[ \t]*include[ \t]*"([^"\n]+)\")", std::regex::multiline);
  for (std::sregex_iterator match(text.begin(), text.end(), kInclude), end; match != end; ++match) {
    const std::string name = include((*match)[1], path, root);
    if (sources.count(name) || !fs::is_regular_file(root / name)) continue;
    const Result<Done> gathered = gather(root, name, sources);
    if (!gathered) return gathered;
  }
  return Done{};
}

std::string preamble(const std::vector<ShaderDefine>& defines) {
  std::string text = "#extension GL_GOOGLE_include_directive : require\n";
  for (const ShaderDefine& define : defines) text += fmt::format("#define {} {}\n", define.name, define.value);
  return text;
}

std::string cacheKey(const Shader& shader, const Sources& sources) {
  const glslang::Version version = glslang::GetVersion();
  std::string all = fmt::format("glslang {}.{}.{}{}\n{}\n{}", version.major, version.minor, version.patch, version.flavor, shader.path,
                                preamble(shader.defines));
  for (const auto& [path, text] : sources) all += fmt::format("\n{} {}\n{}", path, text.size(), text);
  return contentHash(std::as_bytes(std::span(all)));
}

/// A cache entry is magic, hash of the words, words.
std::optional<std::vector<std::uint32_t>> readCache(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return std::nullopt;
  const Result<std::vector<std::byte>> bytes = readFile(path, kMaxShaderBytes);
  constexpr std::size_t kHeader = sizeof kCacheMagic + kHashDigits;
  if (!bytes || bytes.value().size() <= kHeader || (bytes.value().size() - kHeader) % sizeof(std::uint32_t) != 0) return std::nullopt;
  const std::byte* data = bytes.value().data();
  std::uint32_t magic = 0;
  std::memcpy(&magic, data, sizeof magic);
  const std::string hash(reinterpret_cast<const char*>(data + sizeof magic), kHashDigits);
  const std::span<const std::byte> payload(data + kHeader, bytes.value().size() - kHeader);
  if (magic != kCacheMagic || contentHash(payload) != hash) return std::nullopt;
  std::vector<std::uint32_t> words(payload.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), payload.data(), payload.size());
  return words;
}

void writeCache(const fs::path& path, const std::vector<std::uint32_t>& words) {
  const std::span<const std::byte> payload = std::as_bytes(std::span(words));
  const std::string hash = contentHash(payload);
  std::vector<std::byte> bytes(sizeof kCacheMagic + kHashDigits + payload.size());
  std::memcpy(bytes.data(), &kCacheMagic, sizeof kCacheMagic);
  std::memcpy(bytes.data() + sizeof kCacheMagic, hash.data(), kHashDigits);
  std::memcpy(bytes.data() + sizeof kCacheMagic + kHashDigits, payload.data(), payload.size());
  // A cache that cannot be written costs only time.
  static_cast<void>(writeFileAtomically(path, bytes));
}

/// Serves the texts that were hashed, so that what is compiled is what the key names.
class Includer : public glslang::TShader::Includer {
 public:
  Includer(const Sources& sources, const fs::path& root) : sources_(sources), root_(root) {}

  IncludeResult* includeLocal(const char* name, const char* from, std::size_t) override {
    const auto found = sources_.find(include(name, from, root_));
    if (found == sources_.end()) return nullptr;
    return new IncludeResult(found->first, found->second.data(), found->second.size(), nullptr);
  }
  void releaseInclude(IncludeResult* result) override { delete result; }

 private:
  const Sources& sources_;
  const fs::path& root_;
};

/// glslang's log says "ERROR: file:line: what" for each error; the first is the one that matters.
Error firstError(const std::string& log, const std::string& path) {
  static const std::regex kError(R"(ERROR: ([^\n]*?):(\d+): ([^\n]*))");
  std::smatch match;
  if (std::regex_search(log, match, kError)) {
    const std::string file = match[1].str().empty() || match[1].str() == "0" ? path : match[1].str();
    return {file, fmt::format("line {}", match[2].str()), match[3]};
  }
  return {path, "", log.substr(0, log.find('\n'))};
}

EShLanguage language(VkShaderStageFlagBits stage) {
  if (stage == VK_SHADER_STAGE_VERTEX_BIT) return EShLangVertex;
  return stage == VK_SHADER_STAGE_FRAGMENT_BIT ? EShLangFragment : EShLangCompute;
}

Result<std::vector<std::uint32_t>> compile(const Shader& shader, const Sources& sources, const fs::path& root) {
  static const bool started = glslang::InitializeProcess();
  OVERCAST_REQUIRE(started, "glslang does not start");
  const EShLanguage stage = language(shaderStage(shader.path));
  const std::string& text = sources.at(shader.path);
  const char* strings[] = {text.data()};
  const int lengths[] = {static_cast<int>(text.size())};
  const char* names[] = {shader.path.c_str()};
  const std::string before = preamble(shader.defines);

  glslang::TShader unit(stage);
  unit.setStringsWithLengthsAndNames(strings, lengths, names, 1);
  unit.setPreamble(before.c_str());
  unit.setEnvInput(glslang::EShSourceGlsl, stage, glslang::EShClientVulkan, 100);
  unit.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  unit.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  Includer includer(sources, root);
  const auto rules = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
  if (!unit.parse(GetDefaultResources(), 460, false, rules, includer)) return firstError(unit.getInfoLog(), shader.path);
  glslang::TProgram program;
  program.addShader(&unit);
  if (!program.link(rules)) return firstError(program.getInfoLog(), shader.path);

  std::vector<std::uint32_t> words;
  spv::SpvBuildLogger logger;
  glslang::SpvOptions options;
  options.disableOptimizer = false;
  glslang::GlslangToSpv(*program.getIntermediate(stage), words, &logger, &options);
  if (words.empty()) return Error{shader.path, "", "glslang made no SPIR-V: " + logger.getAllMessages()};
  return words;
}

}  // namespace

Result<std::filesystem::path> shaderRoot() {
  const fs::path marker = fs::path("runtime") / "shared_types.h";
  std::error_code ignored;
  if (const char* chosen = std::getenv("OVERCAST_SHADERS"); chosen && *chosen) {
    if (fs::is_regular_file(fs::path(chosen) / marker, ignored)) return fs::path(chosen);
    return Error{chosen, "", "OVERCAST_SHADERS names a folder without " + marker.string()};
  }
  if (fs::is_regular_file(fs::path(OVERCAST_SHADER_ROOT) / marker, ignored)) return fs::path(OVERCAST_SHADER_ROOT);
  const fs::path installed = fs::read_symlink("/proc/self/exe", ignored).parent_path() / "../share/overcast/shaders";
  if (fs::is_regular_file(installed / marker, ignored)) return installed.lexically_normal();
  return Error{"", "", "the shader files were not found: set OVERCAST_SHADERS to the folder that holds runtime/"};
}

std::filesystem::path shaderCacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "overcast" / "shaders";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "overcast" / "shaders";
  return {};
}

VkShaderStageFlagBits shaderStage(const std::string& path) {
  if (path.ends_with(".vert.glsl")) return VK_SHADER_STAGE_VERTEX_BIT;
  if (path.ends_with(".frag.glsl")) return VK_SHADER_STAGE_FRAGMENT_BIT;
  OVERCAST_REQUIRE(path.ends_with(".comp.glsl"), "{} has no stage in its name", path);
  return VK_SHADER_STAGE_COMPUTE_BIT;
}

Result<Spirv> compileShader(const Shader& shader) {
  const Result<fs::path> root = shaderRoot();
  if (!root) return root.error();
  Sources sources;
  const Result<Done> gathered = gather(root.value(), shader.path, sources);
  if (!gathered) return gathered.error();
  const fs::path folder = shaderCacheFolder();
  const fs::path entry = folder / (cacheKey(shader, sources) + ".spv");
  if (!folder.empty())
    if (auto words = readCache(entry)) return Spirv{std::move(*words), true};
  Result<std::vector<std::uint32_t>> words = compile(shader, sources, root.value());
  if (!words) return words.error();
  if (!folder.empty()) writeCache(entry, words.value());
  return Spirv{std::move(words).value(), false};
}

}  // namespace overcast
