#include "daemon/machine/tool_guide.h"

#include <charconv>
#include <istream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

namespace tiltfeed::daemon {

namespace {

std::string help(const std::string& orders) {
  const bool measures = orders.find("tool measure") != orders.npos;
  return std::string("Mount the tool. Then: a number is its length from gauge line to tip in mm; ") +
         (measures ? "`tool measure Z-30 F50 setter=-120.5` measures it; " : "") +
         "`go` shows the way back and asks; `quit` ends the run here.\n" +
         (orders.empty() ? "" : "Of the commands of `tiltfeed machine` there are " + orders + ".\n");
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

class Talk {
 public:
  Talk(const ToolGuide& guide, std::istream& in, std::ostream& out) : guide_(guide), in_(in), out_(out) {}

  Result<void> run() {
    out_ << guide_.title << "\n" << help(guide_.orders);
    for (std::string line; out_ << "tool change> " << std::flush, std::getline(in_, line);) {
      const std::vector<std::string> words = split(line);
      if (words.empty()) continue;
      if (words[0] == "quit") break;
      if (words[0] == "go" && agreed()) return {};
      if (words[0] == "go") continue;
      const std::optional<double> length = words.size() == 1 ? number_of(words[0]) : std::nullopt;
      if (length)
        take(*length);
      else
        perform(words);
    }
    return fail(Code::kCancelled, "the tool change was not ended");
  }

 private:
  bool say(const Result<std::string>& answer) {
    out_ << (answer ? *answer : answer.error().message) << "\n";
    return answer.has_value();
  }
  void take(double length) { known_ = say(guide_.take_length(length)) || known_; }

  void perform(const std::vector<std::string>& words) {
    const Result<MachineAnswer> answer = guide_.act(words[0], {words.begin() + 1, words.end()});
    out_ << (answer ? answer->text : answer.error().message) << "\n";
    if (!answer || words[0] != "tool") return;
    const auto json = nlohmann::json::parse(answer->json, nullptr, false);
    if (json.is_object() && json.contains("length")) take(json.value("length", 0.0));
  }

  bool agreed() {
    if (guide_.wants_length && !known_) {
      out_ << "say or measure the tool's length first: the program's words are for a certain one\n";
      return false;
    }
    if (!say(guide_.way_back())) return false;
    out_ << kBackQuestion << std::flush;
    std::string line;
    return std::getline(in_, line) && line == "yes";
  }

  const ToolGuide& guide_;
  std::istream& in_;
  std::ostream& out_;
  bool known_ = false;
};

}  // namespace

Result<void> guide_tool_change(const ToolGuide& guide, std::istream& in, std::ostream& out) {
  return Talk(guide, in, out).run();
}

}  // namespace tiltfeed::daemon
