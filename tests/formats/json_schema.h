// Our JSON Schemas, and whether a document keeps to one.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace overcast::test {

/// formats/schema/<name>.schema.json
nlohmann::ordered_json schema(const std::string& name);

/// The reason why `json` breaks `schema`, or nothing. Knows just the keywords that our schemas use, and fails on any other.
std::string violation(const nlohmann::ordered_json& schema, const nlohmann::ordered_json& json, const nlohmann::ordered_json& root,
                      const std::string& place = "");

}  // namespace overcast::test
