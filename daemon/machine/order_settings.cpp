// `machine settings`, `console`, `override`.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/protocol/grbl_words.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

struct SettingLine {
  int number = 0;
  std::string value;
};

/// "$110=500", "110=500".
std::optional<SettingLine> setting_line(std::string_view text) {
  if (text.starts_with('$')) text.remove_prefix(1);
  SettingLine line;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), line.number);
  if (parsed.ec != std::errc() || parsed.ptr == text.data() + text.size() || *parsed.ptr != '=' ||
      line.number < 0)
    return std::nullopt;
  line.value = text.substr(static_cast<std::size_t>(parsed.ptr - text.data()) + 1);
  return line;
}

Result<std::vector<SettingLine>> read_settings(GrblTalk& talk) {
  const Result<GrblAnswer> said = obeyed(talk.ask("$$"), "$$");
  if (!said) return tl::unexpected<Error>(said.error());
  std::vector<SettingLine> found;
  for (const std::string& line : said->said)
    if (line.starts_with('$'))
      if (const auto one = setting_line(line)) found.push_back(*one);
  if (found.empty()) return fail(Code::kLink, "the controller has no numbered settings (`$$`)");
  return found;
}

/// The same number, or the same text.
bool same_value(const std::string& a, const std::string& b) {
  double x = 0.0, y = 0.0;
  const auto number = [](const std::string& text, double& value) {
    const auto parsed =
        std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    return parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  };
  return number(a, x) && number(b, y) ? std::abs(x - y) < 0.0005 + 1e-9 * std::abs(x) : a == b;
}

std::string setting_text(const SettingLine& line, const std::string& letters) {
  const GrblSettingName name = grbl_setting_name(line.number, letters);
  std::string text = "$" + std::to_string(line.number) + "=" + line.value;
  if (!name.name.empty()) text += std::string(text.size() < 20 ? 20 - text.size() : 1, ' ') + name.name;
  return text + (name.unit.empty() ? "" : ", " + name.unit);
}

ordered_json setting_json(const SettingLine& line, const std::string& letters) {
  const GrblSettingName name = grbl_setting_name(line.number, letters);
  return {{"number", line.number}, {"value", line.value}, {"name", name.name}, {"unit", name.unit}};
}

Result<MachineAnswer> set_setting(GrblTalk& talk, const std::string& word) {
  const auto wanted = setting_line(word);
  const bool plain = wanted && std::all_of(wanted->value.begin(), wanted->value.end(), [](char c) {
                       return c > ' ' && c <= '~' && c != '!' && c != '?';
                     });
  if (!plain || wanted->value.empty())
    return wrong_words("settings", "'" + wire_text(word) + "' is no NUMBER=VALUE");
  const std::string line = "$" + std::to_string(wanted->number) + "=" + wanted->value;
  if (const Result<GrblAnswer> done = obeyed(talk.ask(line), line); !done)
    return tl::unexpected<Error>(done.error());
  const Result<std::vector<SettingLine>> now = read_settings(talk);
  if (!now) return tl::unexpected<Error>(now.error());
  for (const SettingLine& one : *now) {
    if (one.number != wanted->number) continue;
    if (!same_value(one.value, wanted->value))
      return fail(Code::kLink, line + " was taken, and the controller says $" + std::to_string(one.number) +
                                   "=" + one.value);
    return MachineAnswer{"set: " + setting_text(one, talk.letters()),
                         setting_json(one, talk.letters()).dump()};
  }
  return fail(Code::kLink, line + " was taken, and the controller does not list it");
}

// ---- overrides -------------------------------------------------------------------------------------------

struct OverrideKind {
  const char* name;
  unsigned char full, up10, down10, up1, down1;
  int GrblStatus::*reported;
};
constexpr OverrideKind kOverrides[] = {
    {"feed", 0x90, 0x91, 0x92, 0x93, 0x94, &GrblStatus::feed_override},
    {"rapid", 0x95, 0, 0, 0, 0, &GrblStatus::rapid_override},
    {"spindle", 0x99, 0x9A, 0x9B, 0x9C, 0x9D, &GrblStatus::spindle_override},
};
constexpr unsigned char kRapidHalf = 0x96, kRapidQuarter = 0x97;

/// From 100 % on, so that it does not matter what was in force.
std::string override_bytes(const OverrideKind& kind, int percent) {
  const auto byte = [](unsigned char one) { return static_cast<char>(one); };
  if (kind.up10 == 0) return {byte(percent == 100 ? kind.full : percent == 50 ? kRapidHalf : kRapidQuarter)};
  const int far = percent - 100;
  std::string bytes{byte(kind.full)};
  bytes += std::string(static_cast<std::size_t>(std::abs(far) / 10), byte(far > 0 ? kind.up10 : kind.down10));
  return bytes +
         std::string(static_cast<std::size_t>(std::abs(far) % 10), byte(far > 0 ? kind.up1 : kind.down1));
}

}  // namespace

Result<MachineAnswer> grbl_settings(const MachineBench& bench, const OrderWords& words) {
  const bool set = words.size() == 2 && words[0] == "set";
  if (!words.empty() && !set) return wrong_words("settings", "this is none of its forms");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  if (const Result<GrblStatus> said = idle_machine(talk, "settings"); !said)
    return tl::unexpected<Error>(said.error());
  if (set) return set_setting(talk, words[1]);
  const Result<std::vector<SettingLine>> found = read_settings(talk);
  if (!found) return tl::unexpected<Error>(found.error());
  MachineAnswer answer;
  ordered_json json = {{"settings", ordered_json::array()}};
  for (const SettingLine& one : *found) {
    answer.text += (answer.text.empty() ? "" : "\n") + setting_text(one, talk.letters());
    json["settings"].push_back(setting_json(one, talk.letters()));
  }
  answer.json = json.dump();
  return answer;
}

Result<MachineAnswer> grbl_console(const MachineBench& bench, const OrderWords& words) {
  constexpr std::size_t kMostLine = 255;
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  const bool plain = std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (line.empty() || !plain || line.size() > kMostLine)
    return wrong_words("console", "one line of plain text");
  if (line.find_first_of("!?~") != line.npos)
    return wrong_words(
        "console",
        "! ? ~ act at once wherever they stand: hold, status and resume are commands of their own");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<GrblStatus> said = talk.report();
  if (!said) return tl::unexpected<Error>(said.error());
  if (said->state != "Idle" && !said->state.starts_with("Alarm") && said->state != "Check") {
    const Result<GrblStatus> refused = idle_machine(talk, "console");
    if (!refused) return tl::unexpected<Error>(refused.error());
  }
  const Result<GrblAnswer> done = talk.ask(line);
  if (!done && done.error().code == Code::kCancelled)
    return tl::unexpected<Error>(stopped_by_operator(bench, "the line"));
  if (!done) return tl::unexpected<Error>(done.error());
  MachineAnswer answer;
  for (const std::string& one : done->said) answer.text += one + "\n";
  if (const Result<GrblAnswer> good = obeyed(done, line); !good)
    return fail(Code::kLink, answer.text + good.error().message);
  answer.text += "ok";
  answer.json = ordered_json({{"line", line}, {"said", done->said}, {"end", "ok"}}).dump();
  return answer;
}

Result<MachineAnswer> grbl_override(const MachineBench& bench, const OrderWords& words) {
  const std::optional<int> percent = override_percent(words);
  const auto* const kind =
      std::find_if(std::begin(kOverrides), std::end(kOverrides),
                   [&](const OverrideKind& k) { return !words.empty() && words[0] == k.name; });
  if (!percent || kind == std::end(kOverrides))
    return wrong_words("override", "which, and 10 to 200 percent");
  if (kind->up10 == 0 && *percent != 25 && *percent != 50 && *percent != 100)
    return wrong_words("override", "a rapid override is 25, 50 or 100 percent");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  if (const Result<GrblStatus> said = talk.report(); !said) return tl::unexpected<Error>(said.error());
  if (const Result<void> sent = talk.urge(override_bytes(*kind, *percent)); !sent)
    return tl::unexpected<Error>(sent.error());
  constexpr double kToldAgain = 10.0;  // s: they come with each twentieth report at the latest
  const auto wanted = [&](const GrblStatus& s) { return s.*(kind->reported) == *percent; };
  if (const Result<GrblStatus> there = talk.report_until(wanted, kToldAgain); !there)
    return fail(there.error().code, there.error().code == Code::kCancelled
                                        ? there.error().message
                                        : "the controller does not report the " + words[0] + " override of " +
                                              words[1] + " percent that was sent");
  return MachineAnswer{words[0] + " override " + words[1] + " %",
                       ordered_json({{"override", words[0]}, {"percent", *percent}}).dump()};
}

}  // namespace tiltfeed::daemon
