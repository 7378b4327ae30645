// What an operator asks of a RepRap firmware that moves nothing: settings (M503), the console, the override.

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/machine/reprap_talk.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

/// "echo:  M203 X500.00 ; mm/s" is "M203 X500.00"; headings and what is no code are empty.
std::string setting_of(std::string_view line) {
  if (line.starts_with("echo:")) line.remove_prefix(5);
  line = line.substr(0, line.find(';'));
  while (line.starts_with(' ')) line.remove_prefix(1);
  while (line.ends_with(' ')) line.remove_suffix(1);
  const bool code = line.size() > 1 && line[0] == 'M' && line[1] >= '0' && line[1] <= '9';
  return code ? std::string(line) : std::string();
}

Result<std::vector<std::string>> read_settings(RepRapTalk& talk) {
  const Result<RepRapAnswer> said = talk.obey("M503 S0");
  if (!said) return tl::unexpected<Error>(said.error());
  std::vector<std::string> found;
  for (const std::string& line : said->said)
    if (std::string one = setting_of(line); !one.empty()) found.push_back(std::move(one));
  if (found.empty()) return fail(Code::kLink, "the firmware tells no settings (M503)");
  return found;
}

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t end = std::min(line.find(' ', at), line.size());
    if (end > at) words.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

/// The same letter with the same number, or the same text.
bool same_code_word(const std::string& a, const std::string& b) {
  double x = 0.0, y = 0.0;
  const auto number = [](const std::string& text, double& value) {
    const auto parsed =
        std::from_chars(text.data() + 1, text.data() + text.size(), value, std::chars_format::fixed);
    return text.size() > 1 && parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  };
  if (a == b) return true;
  return !a.empty() && !b.empty() && a[0] == b[0] && number(a, x) && number(b, y) && x == y;
}

/// Does a line of the listing have all words of what was set?
bool has_words(const std::string& line, const std::vector<std::string>& wanted) {
  const std::vector<std::string> words = words_of(line);
  return std::all_of(wanted.begin(), wanted.end(), [&](const std::string& one) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& w) { return same_code_word(w, one); });
  });
}

Result<MachineAnswer> set_setting(RepRapTalk& talk, const OrderWords& asked) {
  std::string line;
  for (const std::string& word : asked) line += (line.empty() ? "" : " ") + word;
  const bool plain = std::all_of(line.begin(), line.end(),
                                 [](char c) { return c >= ' ' && c <= '~' && c != ';' && c != '*'; });
  if (!plain || setting_of(line) != line || asked.size() < 2)
    return wrong_words("settings", "'" + wire_text(line) + "' is no code with its words, as M203 X500");
  const Result<std::vector<std::string>> before = read_settings(talk);
  if (!before) return tl::unexpected<Error>(before.error());
  const std::string code = words_of(line).front();
  if (std::none_of(before->begin(), before->end(),
                   [&](const std::string& one) { return words_of(one).front() == code; }))
    return fail(Code::kUsage, code + " is none of the firmware's settings (M503); nothing was sent");
  if (const auto done = talk.obey(line); !done) return tl::unexpected<Error>(done.error());
  const Result<std::vector<std::string>> after = read_settings(talk);
  if (!after) return tl::unexpected<Error>(after.error());
  const auto is = std::find_if(after->begin(), after->end(),
                               [&](const std::string& one) { return has_words(one, words_of(line)); });
  if (is == after->end()) return fail(Code::kLink, line + " was taken, and the firmware does not list it");
  const Result<RepRapAnswer> kept = talk.ask("M500");
  if (!kept) return tl::unexpected<Error>(kept.error());
  const bool stored = std::any_of(kept->said.begin(), kept->said.end(), [](const std::string& one) {
    return one.find("Settings Stored") != one.npos;
  });
  return MachineAnswer{
      "set: " + *is +
          (stored ? "" : "; in force until the next start: the firmware does not store it (M500)"),
      ordered_json({{"line", *is}, {"stored", stored}}).dump()};
}

}  // namespace

Result<MachineAnswer> reprap_settings(const MachineBench& bench, const OrderWords& words) {
  const bool set = words.size() > 1 && words[0] == "set";
  if (!words.empty() && !set) return wrong_words("settings", "this is none of its forms");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  if (set) return set_setting(talk, {words.begin() + 1, words.end()});
  const Result<std::vector<std::string>> found = read_settings(talk);
  if (!found) return tl::unexpected<Error>(found.error());
  MachineAnswer answer;
  ordered_json json = {{"settings", ordered_json::array()}};
  for (const std::string& one : *found) {
    answer.text += (answer.text.empty() ? "" : "\n") + one;
    json["settings"].push_back({{"line", one}});
  }
  answer.json = json.dump();
  return answer;
}

Result<MachineAnswer> reprap_console(const MachineBench& bench, const OrderWords& words) {
  constexpr std::size_t kMostLine = 80;
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  const bool plain = std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (line.empty() || !plain || line.size() > kMostLine)
    return wrong_words("console", "one line of plain text, 80 characters at most");
  if (line.find('*') != line.npos || line[0] == 'N' || line[0] == 'n' || line.find("M110") != line.npos)
    return wrong_words("console", "the line gets its number and its checksum here");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<RepRapAnswer> done = talk.ask(line);
  if (!done && done.error().code == Code::kCancelled) {
    const Result<AxisValues> stood = talk.quick_stop();
    return fail(Code::kCancelled, stood ? "the line was stopped on request" : stood.error().message);
  }
  if (!done) return tl::unexpected<Error>(done.error());
  MachineAnswer answer;
  for (const std::string& one : done->said) answer.text += one + "\n";
  if (!done->refusal.empty())
    return fail(Code::kLink,
                answer.text + "the firmware answers to '" + wire_text(line) + "': " + done->refusal);
  answer.text += "ok";
  answer.json = ordered_json({{"line", line}, {"said", done->said}, {"end", "ok"}}).dump();
  return answer;
}

Result<MachineAnswer> reprap_override(const MachineBench& bench, const OrderWords& words) {
  const std::optional<int> percent = override_percent(words);
  if (!percent || words[0] != "feed")
    return wrong_words("override", "a RepRap firmware has a feed override only, of 10 to 200 percent");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  if (const auto done = talk.obey("M220 S" + words[1]); !done) return tl::unexpected<Error>(done.error());
  const Result<RepRapAnswer> told = talk.obey("M220");
  if (!told) return tl::unexpected<Error>(told.error());
  const bool same = std::any_of(told->said.begin(), told->said.end(), [&](const std::string& one) {
    return one.find("FR:" + words[1] + "%") != one.npos;
  });
  if (!same)
    return fail(Code::kLink, "M220 was taken, and the firmware does not report " + words[1] + " percent");
  return MachineAnswer{"feed override " + words[1] + " %",
                       ordered_json({{"override", "feed"}, {"percent", *percent}}).dump()};
}

}  // namespace tiltfeed::daemon
