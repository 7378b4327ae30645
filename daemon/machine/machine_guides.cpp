#include "daemon/machine/machine_guides.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <sstream>
#include <tuple>

#include "config/output_file.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;
/// '$' and the number, or the letter of a code, its number, and the how manyth line of that code it is.
using SettingName = std::tuple<char, int, int>;
using Settings = std::map<SettingName, std::string>;

constexpr std::size_t kMostLines = 4096, kMostBytes = 1u << 20;

/// "$110=500", "M203 X500 Y500". False: it is neither; `twice`: it is there already.
bool add_setting(Settings& found, const std::string& text, bool& twice) {
  int number = 0;
  const bool numbered = !text.empty() && text[0] == '$', code = !text.empty() && text[0] == 'M';
  if (!numbered && !code) return false;
  const auto parsed = std::from_chars(text.data() + 1, text.data() + text.size(), number);
  const auto at = static_cast<std::size_t>(parsed.ptr - text.data());
  if (parsed.ec != std::errc() || (numbered && (at >= text.size() || text[at] != '='))) return false;
  SettingName name{text[0], number, 0};
  while (code && found.contains(name)) ++std::get<2>(name);
  twice = !found.emplace(name, text.substr(std::min(at + 1, text.size()))).second;
  return true;
}

/// "$110: ", "M203 #2: ".
std::string name_text(const SettingName& name) {
  const auto& [letter, number, line] = name;
  return letter + std::to_string(number) + (line > 0 ? " #" + std::to_string(line + 1) : "");
}

/// As `settings set` takes it.
std::vector<std::string> set_words(const SettingName& name, const std::string& value) {
  const auto& [letter, number, line] = name;
  if (letter == '$') return {"set", std::to_string(number) + "=" + value};
  return {"set", letter + std::to_string(number), value};
}

Result<Settings> of_controller(const MachineAct& act) {
  const Result<MachineAnswer> answer = act("settings", {});
  if (!answer) return tl::unexpected<Error>(answer.error());
  Settings found;
  const auto json = ordered_json::parse(answer->json);
  bool twice = false;
  for (const auto& one : json["settings"])
    add_setting(found,
                one.contains("line")
                    ? one.value("line", "")
                    : "$" + std::to_string(one.value("number", 0)) + "=" + one.value("value", ""),
                twice);
  return found;
}

/// "$110=500" a line; blank lines and what begins with ; # ( are passed over.
Result<Settings> of_file(const std::string& path) {
  // A pipe that nobody writes would never end.
  std::error_code none;
  if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
    return fail(Code::kInput, path + ": is not a regular file");
  std::ifstream file(path);
  std::string bytes(kMostBytes + 1, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  if (file.bad() || (bytes.empty() && !file.eof())) return fail(Code::kIo, path + ": cannot be read");
  if (bytes.size() > kMostBytes) return fail(Code::kInput, path + ": is too large for a file of settings");
  std::istringstream in(bytes);
  Settings found;
  std::size_t count = 0;
  for (std::string line; std::getline(in, line);) {
    const auto wrong = [&](const char* what) {
      return fail(Code::kInput,
                  path + ":" + std::to_string(count) + ": " + what + ": '" + wire_text(line) + "'");
    };
    if (++count > kMostLines) return wrong("too many lines for a file of settings");
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == line.npos || line[first] == ';' || line[first] == '#' || line[first] == '(') continue;
    const std::size_t note = line.find_first_of(line[first] == '$' ? ";\r\t " : ";\r\t", first);
    std::string text = line.substr(first, note == line.npos ? note : note - first);
    while (text.ends_with(' ')) text.pop_back();
    bool twice = false;
    if (!add_setting(found, text, twice))
      return wrong("$NUMBER=VALUE, or a code with its words, is expected");
    if (twice) return wrong("this setting is there twice");
  }
  if (found.empty()) return fail(Code::kInput, path + ": has no settings");
  return found;
}

bool same_word(std::string_view a, std::string_view b) {
  if (a == b) return true;
  if (a.empty() || b.empty()) return false;
  const bool lettered = a[0] >= 'A' && a[0] <= 'Z';
  if (lettered && a[0] != b[0]) return false;
  double x = 0.0, y = 0.0;
  const auto number = [&](std::string_view text, double& value) {
    if (lettered) text.remove_prefix(1);
    const auto parsed =
        std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    return parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  };
  return number(a, x) && number(b, y) && x == y;
}

/// Word by word: 6000 is 6000.000, X80 is X80.00.
bool same(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty()) {
    const std::size_t i = std::min(a.find(' '), a.size()), k = std::min(b.find(' '), b.size());
    if (!same_word(a.substr(0, i), b.substr(0, k))) return false;
    a.remove_prefix(std::min(i + 1, a.size()));
    b.remove_prefix(std::min(k + 1, b.size()));
  }
  return a.empty() && b.empty();
}

Result<MachineAnswer> save(const Settings& now, const std::string& path) {
  std::string text;
  for (const auto& [name, value] : now) {
    const auto& [letter, number, line] = name;
    text += letter + std::to_string(number) + (letter == '$' ? "=" : " ") + value + "\n";
  }
  if (const auto written = config::write_file(path, text); !written)
    return tl::unexpected<Error>(written.error());
  return MachineAnswer{path + ": " + std::to_string(now.size()) + " settings",
                       ordered_json({{"file", path}, {"settings", now.size()}}).dump()};
}

Result<MachineAnswer> compare(const Settings& now, const Settings& kept, const std::string& path) {
  std::string text;
  for (const auto& [name, value] : kept) {
    const auto is = now.find(name);
    if (is == now.end() || !same(is->second, value))
      text += "\n" + name_text(name) + ": file " + wire_text(value) + ", controller " +
              (is == now.end() ? "has none" : is->second);
  }
  for (const auto& [name, value] : now)
    if (!kept.contains(name)) text += "\n" + name_text(name) + ": file has none, controller " + value;
  if (!text.empty()) return fail(Code::kInput, path + " and the controller differ:" + text);
  return MachineAnswer{path + ": as in the controller", R"({"same":true})"};
}

/// Some settings want others first (soft limits want homing): what is refused is tried again after the rest.
Result<MachineAnswer> restore(const MachineAct& act, const Settings& now, const Settings& kept) {
  std::vector<std::pair<SettingName, std::string>> open;
  for (const auto& [name, value] : kept)
    if (const auto is = now.find(name); is == now.end() || !same(is->second, value))
      open.emplace_back(name, value);
  const std::size_t all = open.size();
  std::string text;
  for (std::size_t before = all + 1; !open.empty() && open.size() < before;) {
    before = open.size();
    std::vector<std::pair<SettingName, std::string>> refused;
    std::optional<Error> first;
    for (const auto& [name, value] : open) {
      const Result<MachineAnswer> set = act("settings", set_words(name, value));
      if (set) {
        text += set->text + "\n";
        continue;
      }
      if (!first) first = set.error();
      refused.emplace_back(name, value);
    }
    if (refused.size() == before)
      return fail(first->code, first->message + "\n" + std::to_string(all - refused.size()) + " of " +
                                   std::to_string(all) + " settings that differed were restored");
    open = std::move(refused);
  }
  return MachineAnswer{text + std::to_string(all) + " settings restored, " +
                           std::to_string(kept.size() - all) + " were as in the file",
                       ordered_json({{"restored", all}, {"same", kept.size() - all}}).dump()};
}

}  // namespace

bool is_settings_file(const std::string& name, const std::vector<std::string>& words) {
  return name == "settings" && words.size() == 2 &&
         (words[0] == "save" || words[0] == "restore" || words[0] == "compare");
}

Result<MachineAnswer> settings_file(const MachineAct& act, const std::string& what, const std::string& path) {
  Result<Settings> kept;
  if (what != "save") kept = of_file(path);
  if (!kept) return tl::unexpected<Error>(kept.error());
  const Result<Settings> now = of_controller(act);
  if (!now) return tl::unexpected<Error>(now.error());
  if (what == "save") return save(*now, path);
  return what == "compare" ? compare(*now, *kept, path) : restore(act, *now, *kept);
}

Result<MachineAnswer> change_tool(const MachineAct& act, std::istream& in, std::ostream& out) {
  const Result<MachineAnswer> parked = act("tool", {"park"});
  if (!parked) return parked;
  out << parked->text << "\nChange the tool, then press Enter: " << std::flush;
  const auto ended = [] {
    return fail(Code::kCancelled, "the tool change was not ended: nothing is known of the tool");
  };
  std::string line;
  if (!std::getline(in, line)) return ended();
  out << "Its length from gauge line to tip in mm, or how to measure it (Z-30 F50 setter=-120.5): "
      << std::flush;
  if (!std::getline(in, line)) return ended();
  double length = 0.0;
  std::istringstream number(line);
  std::string rest;
  std::string how = "as entered";
  if (!(number >> length) || number >> rest) {
    std::vector<std::string> words{"measure"};
    std::istringstream text(line);
    for (std::string word; text >> word;) words.push_back(word);
    const Result<MachineAnswer> measured = act("tool", words);
    if (!measured) return measured;
    length = ordered_json::parse(measured->json).value("length", 0.0);
    how = measured->text;
  }
  if (!(length > 0.0 && length < 1e4))
    return fail(Code::kUsage, "a tool's length is above 0 and below 10000 mm");
  std::ostringstream text;
  text << "tool length " << length << " mm, " << how << "; `tiltfeed send PROGRAM --tool-length " << length
       << "` refuses a program for another";
  return MachineAnswer{text.str(), ordered_json({{"length", length}}).dump()};
}

}  // namespace tiltfeed::daemon
