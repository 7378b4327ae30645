#include "desk/api/job_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "config/job_catalogue.h"
#include "config/key_names.h"
#include "config/yaml_edit.h"

namespace tiltfeed::desk {

using nlohmann::json;

Result<std::string> job_schema(const std::string& text) {
  const Result<config::KeyLog> log = config::job_keys(text);
  if (!log) return tl::unexpected<Error>(log.error());
  std::vector<std::string> paths;
  for (const config::KeyFact& fact : log->facts()) paths.push_back(fact.path);
  const Result<std::vector<std::string>> values = config::value_texts(text, paths);
  if (!values) return tl::unexpected<Error>(values.error());
  json keys = json::array();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const config::KeyFact& fact = log->facts()[i];
    json key{{"key", fact.path},
             {"kind", config::word_of(fact.kind)},
             {"unit", config::unit_of(fact.path)},
             {"required", fact.required},
             {"help", config::key_help(fact.path)}};
    if (fact.range) {
      key["min"] = fact.range->min;
      key["max"] = fact.range->max;
      key["above_min"] = fact.range->above_min;
      key["below_max"] = fact.range->below_max;
      if (*fact.range->reason != '\0') key["reason"] = fact.range->reason;
    }
    if (!fact.usual.empty()) key["default"] = fact.usual;
    if (!fact.words.empty()) key["words"] = fact.words;
    if (fact.most > 0) key["least"] = fact.least, key["most"] = fact.most;
    if (!fact.unused.empty()) key["unused"] = fact.unused;
    if (fact.present)
      key["value"] = (*values)[i], key["line"] = fact.place.line, key["column"] = fact.place.column;
    keys.push_back(std::move(key));
  }
  return json{{"keys", keys},
              {"sections",
               [] {
                 json sections = json::object();
                 for (const char* name :
                      {"part", "cutter", "axis", "pattern", "containment", "stock", "points", "guards",
                       "guards.shank", "guards.holder", "links", "feeds", "program", "setup"})
                   sections[name] = config::key_help(name);
                 return sections;
               }()}}
      .dump(-1, ' ', true, json::error_handler_t::replace);
}

}  // namespace tiltfeed::desk
