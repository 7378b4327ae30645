#include "config/section.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "config/description.h"
#include "config/key_log.h"
#include "config/key_names.h"
#include "config/letters.h"

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMostProblems = 20;    // a screenful
constexpr std::size_t kMaxTextBytes = 1024;  // longer than any sensible file name
constexpr std::size_t kMaxNameBytes = 40;    // a G-code header line holds it whole

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// "a number of mm", "a whole number".
std::string wanted_number(const char* key, const char* kind) {
  const std::string unit = unit_of(key);
  return std::string("a ") + kind + (unit.empty() ? "" : " of " + unit);
}

std::string wanted_range(Range range) {
  return (range.above_min ? "above " : "at least ") + exact_text(range.min) +
         (range.below_max ? " and below " : " and at most ") + exact_text(range.max) +
         (*range.reason != '\0' ? std::string("; ") + range.reason : "");
}

/// The text without one leading '+', which from_chars does not take.
std::string_view without_plus(const std::string& text) {
  const bool plus = text.size() > 1 && text[0] == '+' && (is_digit(text[1]) || text[1] == '.');
  return std::string_view(text).substr(plus ? 1 : 0);
}

/// 0777 is 511 to some YAML readers and 777 to others.
bool looks_octal(std::string_view text) {
  if (!text.empty() && text[0] == '-') text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && is_digit(text[1]);
}

/// Why a text is not a number, as a remedy; may be empty.
std::string number_remedy(const YamlNode& node, const char* key) {
  if (node.kind != YamlKind::kScalar) return "";
  const std::string_view text = without_plus(node.text);
  const std::string quotes = node.plain ? "" : "; remove the quotes";
  if (const std::size_t comma = text.find(','); comma != std::string_view::npos) {
    std::string point(text);
    point[comma] = '.';
    return quotes + "; that is a decimal comma, write decimals with a point: " + point;
  }
  if (!node.plain) return quotes;
  if (looks_octal(text)) return "; write it without the leading zero";
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code == std::errc::result_out_of_range) return "; it does not fit a double";
  if (code == std::errc() && !std::isfinite(value)) return "; it must be finite";
  if (code == std::errc())
    return unit_of(key).empty() ? "; write the number alone"
                                : "; write the number alone, the key states the unit";
  if (text.starts_with('.') || text.starts_with("-.")) return "; it must be finite";
  return "";
}

}  // namespace

void Complaint::add(TextPlace place, const std::string& message, Code code) {
  if (problems_.empty()) code_ = code;
  // What a value is checked for once it is wrong says no more of it.
  const auto about = [](const std::string& text) { return text.substr(0, text.find(": ")); };
  const bool told = std::any_of(problems_.begin(), problems_.end(), [&](const Problem& other) {
    return other.place.line == place.line && other.place.column == place.column &&
           about(other.message) == about(message);
  });
  if (!told) problems_.push_back({place, message});
}

bool Complaint::tells_of(TextPlace place) const {
  return std::any_of(problems_.begin(), problems_.end(), [&](const Problem& problem) {
    return problem.place.line == place.line && problem.place.column == place.column;
  });
}

void Complaint::add_missing(TextPlace place, const std::string& key) {
  const std::size_t before = problems_.size();
  add(place, "missing key " + quoted(key));
  if (problems_.size() > before) problems_.back().missing = key;
}

std::vector<std::string> Complaint::take_missing() {
  std::vector<std::string> keys;
  for (const Problem& problem : problems_)
    if (!problem.missing.empty()) keys.push_back(problem.missing);
  std::erase_if(problems_, [](const Problem& problem) { return !problem.missing.empty(); });
  return keys;
}

std::optional<Error> Complaint::error() const {
  if (problems_.empty()) return std::nullopt;
  std::string text;
  for (std::size_t i = 0; i < std::min(problems_.size(), kMostProblems); ++i)
    text += (i == 0 ? "" : "\n") + to_string(file_, problems_[i].place) + ": " + problems_[i].message;
  if (problems_.size() > kMostProblems)
    text += "\n" + file_ + ": and " + std::to_string(problems_.size() - kMostProblems) + " more";
  return Error{code_, text};
}

Section::Section(std::string name, std::initializer_list<const char*> known, Complaint& complaint)
    : name_(std::move(name)), known_(known.begin(), known.end()), complaint_(&complaint) {
  if (complaint.log() != nullptr) complaint.log()->add_section(name_, known_);
}

Section::Section(const YamlNode& node, std::string name, std::initializer_list<const char*> known,
                 Complaint& complaint)
    : Section(std::move(name), known, complaint) {
  if (node.kind == YamlKind::kMap) {
    map_ = &node;
    check_keys();
    return;
  }
  const bool no_blank = node.kind == YamlKind::kScalar && node.text.find(':') != std::string::npos;
  complaint.add(node.place, (name_.empty() ? "" : name_ + ": ") + "expected the keys " + joined(known_) +
                                ", " + found(node) + (no_blank ? "; put a blank after each ':'" : ""));
}

void Section::check_keys() const {
  for (const YamlKey& key : map_->keys) {
    if (std::find(known_.begin(), known_.end(), key.text) != known_.end()) continue;
    if (std::all_of(key.text.begin(), key.text.end(), is_digit)) {
      complaint_->add(key.place, (name_.empty() ? "" : name_ + ": ") + "found " + quoted(key.text) +
                                     " for a key; a decimal comma before it? Write decimals with a point");
      continue;
    }
    const std::string& nearest = nearest_key(key.text, known_);
    const std::string unit = unit_of(nearest);
    const bool other_unit = !unit.empty() && key.text.starts_with(stem_of(nearest));
    complaint_->add(key.place, "unknown key " + quoted(key.text) + (name_.empty() ? "" : " in " + name_) +
                                   "; nearest known key: " + nearest +
                                   (other_unit ? " (unit: " + unit + ")" : "") +
                                   " (known here: " + joined(known_) + ")");
  }
}

std::string Section::path_of(const char* key) const { return name_.empty() ? key : name_ + "." + key; }

const YamlNode* Section::find(const char* key) const {
  assert(std::find(known_.begin(), known_.end(), key) != known_.end());
  if (map_ == nullptr) return nullptr;
  for (std::size_t i = 0; i < map_->keys.size(); ++i)
    if (map_->keys[i].text == key) return &map_->items[i];
  return nullptr;
}

const YamlNode* Section::want(const char* key, bool required) const {
  const YamlNode* node = find(key);
  if (node == nullptr && required && map_ != nullptr) complaint_->add_missing(map_->place, path_of(key));
  return node;
}

void Section::note(const char* key, const KeyFact& fact) const {
  if (complaint_->log() == nullptr) return;
  KeyFact noted = fact;
  noted.path = path_of(key);
  const YamlNode* node = find(key);
  noted.present = node != nullptr;
  if (node != nullptr) noted.place = node->place;
  complaint_->log()->add(std::move(noted));
}

bool Section::sound(const char* key) const {
  const YamlNode* node = find(key);
  return node != nullptr && !complaint_->tells_of(node->place);
}

void Section::complain(const char* key, const std::string& message, Code code) const {
  const YamlNode* node = find(key);
  const TextPlace place = node != nullptr ? node->place : map_ != nullptr ? map_->place : TextPlace{};
  complaint_->add(place, path_of(key) + ": " + message, code);
}

void Section::unused(const char* key, const std::string& why) const {
  note(key, {.unused = why});
  if (has(key) && !complaint_->doubts(name_)) complain(key, "not used " + why + "; remove it");
}

Section Section::section(const char* key, std::initializer_list<const char*> known) const {
  const YamlNode* node = want(key, true);
  return node != nullptr ? Section(*node, path_of(key), known, *complaint_)
                         : Section(path_of(key), known, *complaint_);
}

Section Section::optional_section(const char* key, std::initializer_list<const char*> known) const {
  return has(key) ? section(key, known) : Section(path_of(key), known, *complaint_);
}

std::optional<double> Section::finite(const YamlNode& node, const std::string& name, const char* key,
                                      Range range) const {
  const auto complain_here = [&](const std::string& message) {
    complaint_->add(node.place, name + ": " + message);
    return std::nullopt;
  };
  const std::string_view text = without_plus(node.text);
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (node.kind != YamlKind::kScalar || !node.plain || looks_octal(text) || code != std::errc() ||
      end != text.data() + text.size() || !std::isfinite(value))
    return complain_here("expected " + wanted_number(key, "number") + ", " + found(node) +
                         number_remedy(node, key));
  if (value < range.min || value > range.max || (range.above_min && value == range.min) ||
      (range.below_max && value == range.max))
    return complain_here(quoted(node.text) + " is out of range; expected " + wanted_number(key, "number") +
                         " " + wanted_range(range));
  return value + 0.0;  // -0 becomes 0
}

double Section::number(const char* key, Range range, std::optional<double> fallback) const {
  note(key, {.kind = KeyKind::kNumber,
             .range = range,
             .required = !fallback,
             .usual = fallback ? exact_text(tidy(*fallback)) : ""});
  const YamlNode* node = want(key, !fallback);
  if (node == nullptr) return fallback.value_or(range.max);
  return finite(*node, path_of(key), key, range).value_or(range.max);
}

std::optional<double> Section::optional_number(const char* key, Range range) const {
  note(key, {.kind = KeyKind::kNumber, .range = range});
  if (!has(key)) return std::nullopt;
  return number(key, range);
}

int Section::integer(const char* key, int min, int max, std::optional<int> fallback) const {
  note(key, {.kind = KeyKind::kInteger,
             .range = Range{static_cast<double>(min), static_cast<double>(max)},
             .required = !fallback,
             .usual = fallback ? std::to_string(*fallback) : ""});
  const YamlNode* node = want(key, !fallback);
  if (node == nullptr) return fallback.value_or(min);
  const std::string_view text = without_plus(node->text);
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = end == text.data() + text.size() && code == std::errc();
  if (node->kind != YamlKind::kScalar || !node->plain || looks_octal(text) ||
      (!whole && code != std::errc::result_out_of_range)) {
    const bool fraction = code == std::errc() && !looks_octal(text) && node->plain;
    complain(key, "expected " + wanted_number(key, "whole number") + ", " + found(*node) +
                      (fraction ? "; write digits only" : number_remedy(*node, key)));
    return min;
  }
  if (!whole || value < min || value > max) {
    complain(key, quoted(node->text) + " is out of range; expected " + wanted_number(key, "whole number") +
                      " from " + std::to_string(min) + " to " + std::to_string(max));
    return min;
  }
  return static_cast<int>(value);
}

bool Section::flag(const char* key, bool fallback) const {
  return choice<bool>(key, {{"true", true}, {"false", false}}, fallback);
}

std::optional<std::string> Section::scalar(const char* key) const {
  note(key, {.kind = KeyKind::kText});
  const YamlNode* node = find(key);
  if (node == nullptr || node->kind != YamlKind::kScalar) return std::nullopt;
  return node->text;
}

std::string Section::text(const char* key, std::optional<std::string> fallback) const {
  note(key, {.kind = KeyKind::kText, .required = !fallback, .usual = fallback.value_or("")});
  const YamlNode* node = want(key, !fallback);
  const bool may_be_empty = fallback && fallback->empty();
  if (node == nullptr) return fallback.value_or("");
  const std::string& text = node->text;
  if (node->kind != YamlKind::kScalar || (text.empty() && !may_be_empty)) {
    complain(key, "expected a text, " + found(*node));
  } else if (text.size() > kMaxTextBytes) {
    complain(key, "the text has " + std::to_string(text.size()) + " bytes; expected at most " +
                      std::to_string(kMaxTextBytes));
  } else if (text.starts_with(' ') || text.ends_with(' ') ||
             std::any_of(text.begin(), text.end(), [](char letter) {
               const auto byte = static_cast<unsigned char>(letter);
               return byte < 0x20 || byte == 0x7F;
             })) {
    complain(key, "expected one line of text without blanks at its ends, " + found(*node) +
                      "; is a quote left open?");
  }
  return text;
}

std::string Section::name(const char* key) const {
  const std::string value = text(key);
  const bool clean = value.size() <= kMaxNameBytes && std::all_of(value.begin(), value.end(), [](char c) {
                       return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || is_digit(c) || c == ' ' ||
                              c == '.' || c == '_' || c == '-';
                     });
  if (!clean)
    complain(key, "expected 1 to " + std::to_string(kMaxNameBytes) +
                      " of the letters A-Z a-z 0-9, blank, '.', '_' and '-', found " + quoted(value));
  return value;
}

std::optional<std::size_t> Section::choose(const char* key, const std::vector<std::string>& words,
                                           bool optional, const char* usual) const {
  note(key, {.kind = KeyKind::kWord,
             .required = !optional,
             .usual = usual != nullptr ? usual : "",
             .words = words});
  const YamlNode* node = want(key, !optional);
  if (node == nullptr) {
    if (!optional) complaint_->doubt(name_);
    return std::nullopt;
  }
  const auto word = std::find(words.begin(), words.end(), node->text);
  if (node->kind == YamlKind::kScalar && word != words.end())
    return static_cast<std::size_t>(word - words.begin());
  complain(key, "expected one of " + joined(words) + ", " + found(*node));
  complaint_->doubt(name_);
  return std::nullopt;
}

}  // namespace tiltfeed::config
