#include "tests/formats/json_schema.h"

#include <algorithm>
#include <fstream>

namespace overcast::test {
namespace {

using Json = nlohmann::ordered_json;

/// Whether `json` fits the condition of an "if": one property with one of some values.
bool fitsCondition(const Json& condition, const Json& json) {
  for (const auto& [name, rule] : condition.at("properties").items()) {
    const Json& values = rule.at("enum");
    if (json.contains(name) && std::find(values.begin(), values.end(), json.at(name)) == values.end()) return false;
  }
  return true;
}

}  // namespace

Json schema(const std::string& name) {
  std::ifstream file(std::string(OVERCAST_SOURCE_FOLDER) + "/formats/schema/" + name + ".schema.json");
  return Json::parse(file);
}

std::string violation(const Json& schema, const Json& json, const Json& root, const std::string& place) {
  for (const auto& [key, rule] : schema.items()) {
    const bool number = json.is_number();
    if (key == "type") {
      const std::string type = rule;
      const bool fits = (type == "object" && json.is_object()) || (type == "array" && json.is_array()) ||
                        (type == "string" && json.is_string()) || (type == "number" && number) ||
                        (type == "boolean" && json.is_boolean()) || (type == "integer" && json.is_number_integer());
      if (!fits) return place + ": is not of type " + type;
    } else if (key == "required") {
      for (const std::string name : rule)
        if (!json.contains(name)) return place + "/" + name + ": missing";
    } else if (key == "properties") {
      for (const auto& [name, value] : json.items()) {
        if (!rule.contains(name)) return place + "/" + name + ": not in the schema";
        const std::string inner = violation(rule[name], value, root, place + "/" + name);
        if (!inner.empty()) return inner;
      }
    } else if (key == "items") {
      for (const Json& entry : json) {
        const std::string inner = violation(rule, entry, root, place + "/*");
        if (!inner.empty()) return inner;
      }
    } else if (key == "$ref") {
      const std::string inner = violation(root.at(Json::json_pointer(rule.get<std::string>().substr(1))), json, root, place);
      if (!inner.empty()) return inner;
    } else if (key == "if") {
      const std::string inner = violation(schema.at(fitsCondition(rule, json) ? "then" : "else"), json, root, place);
      if (!inner.empty()) return inner;
    } else if (key == "enum") {
      if (std::find(rule.begin(), rule.end(), json) == rule.end()) return place + ": not in the enumeration";
    } else if (key == "minimum") {
      if (json < rule) return place + ": too small";
    } else if (key == "maximum") {
      if (json > rule) return place + ": too large";
    } else if (key == "exclusiveMinimum") {
      if (json <= rule) return place + ": too small";
    } else if (key == "multipleOf") {
      if (json.get<int>() % rule.get<int>() != 0) return place + ": not a multiple";
    } else if (key == "minItems" || key == "minLength") {
      if ((json.is_string() ? json.get<std::string>().size() : json.size()) < rule) return place + ": too short";
    } else if (key == "maxItems") {
      if (json.size() > rule) return place + ": too long";
    } else if (key != "$schema" && key != "$id" && key != "$defs" && key != "title" && key != "description" && key != "default" &&
               key != "pattern" && key != "then" && key != "else") {
      return "the schema uses '" + key + "', which this test does not know";
    }
  }
  return "";
}

}  // namespace overcast::test
