#include "config/key_log.h"

#include <algorithm>

namespace tiltfeed::config {

const char* word_of(KeyKind kind) {
  switch (kind) {
    case KeyKind::kNumber:
      return "number";
    case KeyKind::kInteger:
      return "integer";
    case KeyKind::kWord:
      return "word";
    case KeyKind::kText:
      return "text";
    case KeyKind::kVector:
      return "vector";
    case KeyKind::kDirection:
      return "direction";
    case KeyKind::kDirections:
      return "directions";
    case KeyKind::kInterval:
      return "interval";
    case KeyKind::kPoints:
      return "points";
    case KeyKind::kList:
      break;
  }
  return "list";
}

void KeyLog::add(KeyFact fact) {
  const auto same = [&](const KeyFact& other) { return other.path == fact.path; };
  const auto noted = std::find_if(facts_.begin(), facts_.end(), same);
  if (noted == facts_.end())
    facts_.push_back(std::move(fact));
  else if (noted->unused.empty() && (!fact.unused.empty() || noted->kind == KeyKind::kText))
    *noted = std::move(fact);
}

void KeyLog::add_section(const std::string& path, const std::vector<std::string>& known) {
  if (KeyLog::known(path).empty()) sections_.push_back({path, known});
}

std::vector<std::string> KeyLog::known(const std::string& section) const {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const Known& known) { return known.section == section; });
  return found == sections_.end() ? std::vector<std::string>{} : found->keys;
}

}  // namespace tiltfeed::config
