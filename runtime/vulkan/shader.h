// Shaders: GLSL files to SPIR-V by the glslang library when they are first needed, cached on disk by content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"

namespace overcast {

struct ShaderDefine {
  std::string name;
  std::string value;
};

/// One shader: a file relative to the shader root, named <name>.vert.glsl, <name>.frag.glsl or <name>.comp.glsl (entry point `main`), and
/// what is defined before its first line. Files say `#version 460`; `#include "..."` needs no extension line.
struct Shader {
  std::string path;
  std::vector<ShaderDefine> defines;
};

struct Spirv {
  std::vector<std::uint32_t> words;
  bool fromCache = false;
};

/// The folder that shader paths are relative to (the one that holds `runtime/`): $OVERCAST_SHADERS, else the source folder this was built
/// from, else ../share/overcast/shaders beside the executable.
Result<std::filesystem::path> shaderRoot();

/// $XDG_CACHE_HOME/overcast/shaders, or ~/.cache/overcast/shaders; empty when neither variable is set (then nothing is cached).
std::filesystem::path shaderCacheFolder();

/// Vulkan 1.3 SPIR-V of the shader. `#include "x"` is looked up relative to the shader root, then to the including file. The cache key is
/// the hash of the texts of the file and all it includes, the defines and the glslang version; a damaged entry is compiled again, and a
/// cache that cannot be written costs time only. An Error names the file (of the include, where it is there) and the line.
Result<Spirv> compileShader(const Shader& shader);

/// The stage that the file's name says.
VkShaderStageFlagBits shaderStage(const std::string& path);

}  // namespace overcast
