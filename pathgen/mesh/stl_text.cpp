#include "pathgen/mesh/stl_text.h"

#include <charconv>
#include <limits>
#include <optional>
#include <system_error>

#include "pathgen/mesh/quote.h"

namespace tiltfeed::pathgen {
namespace {

/// Covers the header, the count and the first records of a binary file. Its count is below kMaxFacets, so
/// byte 83 is NUL; text has none.
constexpr std::size_t kProbeBytes = 512;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// `word` is lower case.
bool same_word(std::string_view text, std::string_view word) {
  if (text.size() != word.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (lower(text[i]) != word[i]) return false;
  return true;
}

bool is_keyword(std::string_view text) {
  for (std::string_view word : {"vertex", "facet", "endfacet", "outer", "endloop", "solid", "endsolid"})
    if (same_word(text, word)) return true;
  return false;
}

/// The words of the file, one at a time.
class Words {
 public:
  explicit Words(std::string_view bytes) : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}

  /// The next word without taking it; empty at the end of the file.
  std::string_view peek() {
    if (word_.empty()) {
      while (at_ != end_ && is_space(*at_)) {
        if (is_line_end(at_)) ++line_;
        ++at_;
      }
      const char* word_end = at_;
      while (word_end != end_ && !is_space(*word_end)) ++word_end;
      word_ = {at_, static_cast<std::size_t>(word_end - at_)};
    }
    return word_;
  }
  void take() {
    at_ += word_.size();
    word_ = {};
  }
  /// Takes the next word if it is `word`.
  bool take_if(std::string_view word) {
    if (!same_word(peek(), word)) return false;
    take();
    return true;
  }
  /// Takes words up to a keyword or the end; true if there were any.
  bool skip_remarks() {
    bool any = false;
    for (; !peek().empty() && !is_keyword(peek()); any = true) take();
    return any;
  }
  /// Takes the name after solid or endsolid: the rest of the line, but not a "facet normal" in it, so that a
  /// file all in one line is read too.
  void skip_name() {
    const std::uint64_t line = line_;
    while (!peek().empty() && line_ == line) {
      const char* const before = at_;
      const std::string_view word = word_;
      take();
      if (same_word(word, "facet") && same_word(peek(), "normal") && line_ == line) {
        at_ = before;
        word_ = word;
        return;
      }
    }
  }
  /// Line of the word that peek() shows.
  std::uint64_t line() {
    peek();
    return line_;
  }

 private:
  /// LF, or a CR that no LF follows.
  bool is_line_end(const char* c) const {
    return *c == '\n' || (*c == '\r' && (c + 1 == end_ || c[1] != '\n'));
  }

  const char* at_;
  const char* end_;
  std::string_view word_;
  std::uint64_t line_ = 1;
};

/// A number that is too large or too small for float32, or neither for double.
float out_of_range(std::string_view text) {
  double value = 0.0;
  const bool in_double = std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
  const bool tiny = in_double ? std::abs(value) < 1.0
                              : text.find_first_of("eE") != text.npos && text.find('-', 1) != text.npos;
  if (tiny) return static_cast<float>(in_double ? value : 0.0);
  return std::numeric_limits<float>::infinity();
}

/// The whole word as a float32; nothing if it is no number.
std::optional<float> to_float(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  float value = 0.0F;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc::result_out_of_range ? out_of_range(text) : value;
}

class TextStl {
 public:
  TextStl(std::string_view bytes, const std::string& name) : words_(bytes), name_(name) {}

  Result<Stl> parse() {
    std::uint64_t solids = 0;
    while (words_.take_if("solid")) {
      ++solids;
      words_.skip_name();
      if (auto read = facets(); !read) return tl::unexpected(read.error());
      words_.skip_name();
      const std::uint64_t line = words_.line();
      if (words_.skip_remarks())
        stl_.warnings.push_back(name_ + ":" + std::to_string(line) + ": text after endsolid is ignored");
    }
    if (!words_.peek().empty()) return expected("\"solid\"");
    if (stl_.facets.empty()) {
      return fail(Code::kInput, name_ + ": the file has no facets; export the part again");
    }
    if (solids > 1) {
      stl_.warnings.push_back(name_ + ": " + std::to_string(solids) + " solids are read as one part");
    }
    return std::move(stl_);
  }

 private:
  /// Everything up to and with endsolid.
  Result<void> facets() {
    for (;;) {
      if (words_.take_if("endsolid")) return {};
      if (!words_.take_if("facet")) return expected("\"facet\" or \"endsolid\"");
      if (stl_.facets.size() == kMaxFacets) {
        return fail(Code::kLimit, name_ + ":" + std::to_string(words_.line()) + ": more than the limit of " +
                                      std::to_string(kMaxFacets) +
                                      " facets; export with a coarser tolerance");
      }
      if (auto read = facet(); !read) return read;
    }
  }

  /// What follows the word facet, up to and with endfacet and its remarks.
  Result<void> facet() {
    if (!words_.take_if("normal")) return expected("\"normal\"");
    words_.skip_remarks();
    if (!words_.take_if("outer")) return expected("\"outer loop\"");
    if (!words_.take_if("loop")) return expected("\"loop\"");
    words_.skip_remarks();
    std::array<Point<Part>, 3> corners;
    for (Point<Part>& corner : corners) {
      if (!words_.take_if("vertex")) return expected("\"vertex\"");
      for (double* coordinate : {&corner.x, &corner.y, &corner.z}) {
        const std::optional<float> value = to_float(words_.peek());
        if (!value) return bad_number();
        *coordinate = *value;
        words_.take();
      }
    }
    if (!words_.take_if("endloop")) {
      return expected(same_word(words_.peek(), "vertex") ? "three corners and \"endloop\"" : "\"endloop\"");
    }
    words_.skip_remarks();
    if (!words_.take_if("endfacet")) return expected("\"endfacet\"");
    words_.skip_remarks();
    stl_.facets.push_back(corners);
    return {};
  }

  std::string place() {
    return name_ + ":" + std::to_string(words_.line()) + ": facet " + std::to_string(stl_.facets.size()) +
           ": ";
  }

  tl::unexpected<Error> expected(const std::string& what) {
    if (words_.peek().empty()) {
      return fail(Code::kInput, place() + "the file ends where " + what +
                                    " is due: it is cut short; export or copy the part again");
    }
    return fail(Code::kInput, place() + "expected " + what + ", found " + quote(words_.peek()) +
                                  "; repair the line or export the part again");
  }

  tl::unexpected<Error> bad_number() {
    const std::string_view text = words_.peek();
    if (text.empty() || is_keyword(text)) return expected("a number");
    if (text.find(',') != text.npos) {
      return fail(Code::kInput, place() + quote(text) +
                                    " has a decimal comma; STL needs a decimal point: export the part again "
                                    "with English number format");
    }
    return expected("a number");
  }

  Words words_;
  const std::string& name_;
  Stl stl_;
};

std::string_view without_mark(std::string_view bytes) {
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  return bytes;
}

}  // namespace

bool looks_like_text_stl(std::string_view bytes) {
  const std::string_view probe = without_mark(bytes).substr(0, kProbeBytes);
  if (probe.find('\0') != probe.npos) return false;
  std::size_t at = 0;
  while (at < probe.size() && is_space(probe[at])) ++at;
  const std::string_view first = probe.substr(at, 5);
  return same_word(first, "solid") && (at + 5 == probe.size() || is_space(probe[at + 5]));
}

Result<Stl> parse_text_stl(std::string_view bytes, const std::string& name) {
  return TextStl(without_mark(bytes), name).parse();
}

}  // namespace tiltfeed::pathgen
