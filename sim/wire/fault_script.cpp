#include "sim/wire/fault_script.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

namespace tiltfeed::sim {
namespace {

constexpr const char* kNames[] = {
    "drop",       "duplicate",    "corrupt",      "insert",     "delay",      "lose-ok",    "extra-ok",
    "wrong-line", "resend-storm", "silence",      "disconnect", "xoff-stuck", "slow-read",  "reset",
    "alarm",      "exception",    "lose-request", "lose-reply", "late-reply", "wrong-unit", "half-frame"};
constexpr std::size_t kMostBytes = 1 << 20;

/// Not a number where `text` is none.
double number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? value : std::nan("");
}

std::optional<FaultKind> kind_of(const std::string& word) {
  for (std::size_t i = 0; i < std::size(kNames); ++i)
    if (word == kNames[i]) return static_cast<FaultKind>(i);
  return std::nullopt;
}

/// One word after the kind: a side, or key=number. Nothing is wrong when the result is empty.
std::string take_word(const std::string& word, FaultRule& rule) {
  if (word == "to-machine") return rule.side = Side::kToMachine, "";
  if (word == "to-host") return rule.side = Side::kToHost, "";
  const std::size_t equals = word.find('=');
  const std::string key = word.substr(0, equals);
  const double value = equals == word.npos ? std::nan("") : number(word.substr(equals + 1));
  if (key == "p" && value > 0.0 && value <= 1.0) return rule.probability = value, "";
  if (key == "at" && value >= 0.0) return rule.at = value, "";
  if (key == "for" && value >= 0.0 && value <= 3600.0) return rule.seconds = value, "";
  if (key == "value" && value >= 0.0 && value <= 65535.0) return rule.value = static_cast<int>(value), "";
  return "'" + word + "': expected to-machine, to-host, p=0..1, at=seconds, for=seconds or value=number";
}

}  // namespace

const char* fault_name(FaultKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

Result<FaultScript> parse_fault_script(const std::string& text, const std::string& name) {
  FaultScript script;
  std::istringstream lines(text);
  std::string line, word;
  for (int at = 1; std::getline(lines, line); ++at) {
    const auto bad = [&](const std::string& what) {
      return fail(Code::kInput, name + ":" + std::to_string(at) + ": " + what);
    };
    std::istringstream words(line.substr(0, line.find('#')));
    if (!(words >> word)) continue;
    if (word == "seed") {
      std::uint64_t seed = 0;
      if (!(words >> seed)) return bad("seed: a whole number is missing");
      script.seed = seed;
      continue;
    }
    const auto kind = kind_of(word);
    if (!kind) {
      std::string known;
      for (const char* one : kNames) known += std::string(" ") + one;
      return bad("'" + word + "' is no fault; there are:" + known);
    }
    FaultRule rule;
    rule.kind = *kind;
    while (words >> word)
      if (const std::string wrong = take_word(word, rule); !wrong.empty()) return bad(wrong);
    if ((rule.probability > 0.0) == (rule.at >= 0.0))
      return bad(std::string(fault_name(rule.kind)) + ": one of p= (chance) and at= (time) is needed");
    script.rules.push_back(rule);
  }
  return script;
}

Result<FaultScript> load_fault_script(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  std::string text(kMostBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMostBytes) return fail(Code::kInput, path + ": is longer than 1 MiB");
  return parse_fault_script(text, path);
}

}  // namespace tiltfeed::sim
