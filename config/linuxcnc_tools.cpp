// Tool tables of LinuxCNC [LinuxCNC, Tool Table Format]: a tool a line, words in any order between blanks, a
// remark behind ';'. Lengths are in the machine's unit, which the table does not say.

#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>

#include "config/description.h"
#include "config/json_tree.h"
#include "config/key_ranges.h"
#include "config/tool_readers.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr std::string_view kLetters = "TPDXYZABCUVWIJQ";

class TableLine {
 public:
  TableLine(const std::string& path, int line, double unit_mm, ToolImport& import)
      : path_(path), line_(line), unit_(unit_mm), import_(import) {}

  Result<void> read(const std::string& text) {
    const std::size_t remark = text.find(';');
    std::string words = text.substr(0, remark);
    for (char& c : words)
      if (c == '\t' || c == '\r') c = ' ';
    for (std::size_t at = words.find_first_not_of(' '); at != words.npos;
         at = words.find_first_not_of(' ', at)) {
      const std::size_t end = std::min(words.find(' ', at), words.size());
      if (auto taken = take(words.substr(at, end - at), at); !taken) return taken;
      at = end;
    }
    if (!any_) return {};
    if (tool_.number == 0) return fail_at(0, "no tool number; expected a word as T1");
    if (remark != text.npos) tool_.name = one_line(text.substr(remark + 1));
    tool_.id = "T" + std::to_string(tool_.number);
    if (!left_.empty()) import_.notes.push_back(tool_.id + ": not carried over:" + left_);
    import_.tools.push_back(tool_);
    return {};
  }

 private:
  tl::unexpected<Error> fail_at(std::size_t column, const std::string& message) const {
    return fail(Code::kInput, to_string(path_, {line_, static_cast<int>(column) + 1}) + ": " + message);
  }

  Result<void> take(const std::string& word, std::size_t column) {
    const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
    if (kLetters.find(letter) == kLetters.npos)
      return fail_at(column, quoted(word) +
                                 " is no word of a tool table; expected T P D X Y Z A B C U V W I J Q, "
                                 "and remarks behind ';'");
    const char* from = word.data() + (word.size() > 1 && word[1] == '+' ? 2 : 1);
    const char* const end = word.data() + word.size();
    double value = 0.0;
    const auto [stop, code] = std::from_chars(from, end, value);
    if (code != std::errc() || stop != end || !std::isfinite(value))
      return fail_at(column, quoted(word) + ": expected a number behind " + std::string(1, letter));
    any_ = true;
    switch (letter) {
      case 'T':
        if (value != std::floor(value) || value < 0.0 || value > kHighestToolNumber)
          return fail_at(column, quoted(word) + ": expected a whole number from 0 to 9999");
        tool_.number = static_cast<int>(value);
        if (value == 0.0) any_ = false;  // what is in the spindle, in tables of random changers
        break;
      case 'D':
        if (value > 0.0) tool_.diameter = value * unit_;
        break;
      case 'Z':
        if (value > 0.0)
          tool_.length = value * unit_;
        else if (value < 0.0)
          left_ += " " + word + " (a length from the gauge line to the tip is above 0)";
        break;
      default:
        if (value != 0.0) left_ += " " + word;
    }
    return {};
  }

  const std::string& path_;
  int line_;
  double unit_;
  ToolImport& import_;
  ToolEntry tool_;
  std::string left_;
  bool any_ = false;
};

}  // namespace

Result<ToolImport> read_linuxcnc_tools(const std::string& text, const std::string& path,
                                       const ImportOptions& options) {
  if (!options.unit_mm)
    return fail(Code::kUsage,
                path + ": a tool table does not say its unit, it is the machine's; add --unit mm or inch");
  ToolImport import;
  std::istringstream in(text);
  int number = 0;
  for (std::string line; std::getline(in, line);)
    if (auto read = TableLine(path, ++number, *options.unit_mm, import).read(line); !read)
      return tl::unexpected(read.error());
  if (import.tools.empty()) return fail(Code::kInput, path + ": has no tool");
  import.notes.push_back(
      "a tool table has no cutter form, flutes, shank or holder; Z is taken for the length from the gauge "
      "line to the tip: right where lengths were measured so");
  return import;
}

}  // namespace tiltfeed::config
