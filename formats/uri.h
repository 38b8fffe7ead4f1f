// URIs inside a glTF asset (RFC 3986, glTF 2.0 section 2.8): percent coding of relative paths.
#pragma once

#include <string>
#include <string_view>

namespace overcast {

/// A relative path as a URI: everything but letters, digits and "-._~/" is percent-encoded byte by byte.
std::string uriFromPath(std::string_view path);

/// The path that a URI names: percent escapes decoded, malformed escapes kept as they are. Does not judge where the path leads
/// (formats/files.h: resolveInside).
std::string pathFromUri(std::string_view uri);

}  // namespace overcast
