#include "desk/api/job_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "config/job_catalogue.h"
#include "config/key_names.h"
#include "config/yaml_edit.h"

namespace tiltfeed::desk {

using nlohmann::json;

Result<std::string> job_schema(const std::string& text, std::size_t operation) {
  config::OperationKeys of;
  if (operation == 0) {
    Result<config::KeyLog> log = config::job_keys(text);
    if (!log) return tl::unexpected<Error>(log.error());
    of.log = std::move(*log);
  } else {
    auto all = config::operation_keys(text);
    if (!all) return tl::unexpected<Error>(all.error());
    if (operation > all->size() || all->front().number == 0)
      return fail(Code::kUsage, "there is no operation " + std::to_string(operation));
    of = std::move((*all)[operation - 1]);
  }
  const config::KeyLog* log = &of.log;
  std::vector<std::string> paths;
  for (const config::KeyFact& fact : log->facts()) paths.push_back(of.place(fact.path));
  const Result<std::vector<std::string>> values = config::value_texts(text, paths);
  if (!values) return tl::unexpected<Error>(values.error());
  json keys = json::array();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const config::KeyFact& fact = log->facts()[i];
    if (fact.path.starts_with("operation")) continue;  // what operations are for: a list of their own
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
              {"operation", of.number},
              {"name", of.name},
              {"own", of.own},
              {"sections",
               [] {
                 json sections = json::object();
                 for (const char* name :
                      {"part", "cutter", "axis", "pattern", "rest", "containment", "stock", "points",
                       "guards", "guards.shank", "guards.holder", "links", "feeds", "program", "setup"})
                   sections[name] = config::key_help(name);
                 return sections;
               }()}}
      .dump(-1, ' ', true, json::error_handler_t::replace);
}

}  // namespace tiltfeed::desk
