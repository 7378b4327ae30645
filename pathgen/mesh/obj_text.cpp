#include "pathgen/mesh/obj_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "pathgen/mesh/quote.h"

namespace tiltfeed::pathgen {
namespace {

constexpr std::array<std::string_view, 14> kSkipped{"vt",     "vn",     "vp",         "g",  "s",
                                                    "o",      "usemtl", "mtllib",     "mg", "usemap",
                                                    "maplib", "bevel",  "shadow_obj", "lod"};
constexpr std::array<std::string_view, 24> kFreeForm{
    "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm",  "trim",  "hole", "scrv", "sp",
    "end",    "con", "bzp",  "bsp",  "cdc",  "cdp",   "res",  "ctech", "stech", "call", "csh",  "trace_obj"};
constexpr std::uint64_t kNowhere = 0xFFFFFFFF;  // a corner that no file has

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

template <std::size_t N>
bool is_one_of(std::string_view word, const std::array<std::string_view, N>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The words of the file, statement by statement; a line that ends in a backslash goes on in the next.
class Statements {
 public:
  explicit Statements(std::string_view bytes) : at_(bytes.data()), end_(bytes.data() + bytes.size()) {
    if (bytes.starts_with("\xEF\xBB\xBF")) at_ += 3;
  }
  /// The next word of this statement; empty at its end.
  std::string_view word() {
    while (at_ != end_ && (is_blank(*at_) || goes_on())) {
      if (*at_ == '\\') {
        at_ = std::find(at_, end_, '\n');
        ++line_;
      }
      if (at_ != end_) ++at_;
    }
    if (at_ != end_ && *at_ == '#') at_ = std::find(at_, end_, '\n');
    const char* const from = at_;
    while (at_ != end_ && *at_ != '\n' && !is_blank(*at_) && !goes_on()) ++at_;
    return {from, static_cast<std::size_t>(at_ - from)};
  }
  /// Goes to the next statement; false at the end of the file.
  bool next() {
    while (!word().empty()) {
    }
    if (at_ == end_) return false;
    ++at_, ++line_;
    return true;
  }
  std::uint64_t line() const { return line_; }

 private:
  bool goes_on() const {
    if (*at_ != '\\') return false;
    const char* behind = at_ + 1;
    while (behind != end_ && is_blank(*behind)) ++behind;
    return behind == end_ || *behind == '\n';
  }
  const char* at_;
  const char* end_;
  std::uint64_t line_ = 1;
};

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& name) : in_(bytes), name_(name) {}

  Result<Polygons> read() {
    do {
      const std::string_view word = in_.word();
      if (word.empty() || is_one_of(word, kSkipped)) continue;
      Result<void> taken = word == "v"                   ? corner()
                           : word == "f" || word == "fo" ? face()
                           : word == "l" || word == "p"  ? bare()
                           : is_one_of(word, kFreeForm)
                               ? wrong(std::string(word) +
                                       ": free-form curves and surfaces cannot be read; "
                                       "export the part as triangles")
                               : wrong(quote(word) + " begins no statement of OBJ; export the part again");
      if (!taken) return tl::unexpected(taken.error());
    } while (in_.next());
    if (bare_ > 0)
      polygons_.warnings.push_back(name_ + ": " + std::to_string(bare_) +
                                   " lines and points without a surface are ignored");
    return std::move(polygons_);
  }

 private:
  tl::unexpected<Error> wrong(const std::string& message) const {
    return fail(Code::kInput, name_ + ": line " + std::to_string(in_.line()) + ": " + message);
  }

  /// Behind the coordinates may be a weight or a colour.
  Result<void> corner() {
    double values[3];
    for (double& value : values) {
      const std::string_view word = in_.word();
      const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (code == std::errc() && end == word.data() + word.size()) continue;
      return wrong(word.empty() ? "a corner needs three coordinates"
                                : quote(word) + " is not a number" +
                                      (word.find(',') != word.npos ? "; write decimals with a point" : ""));
    }
    polygons_.corners.push_back({values[0], values[1], values[2]});
    return {};
  }

  /// i, i/t, i//n or i/t/n, counting from 1, or from -1 backwards.
  Result<void> face() {
    const std::uint64_t line = in_.line();
    for (std::string_view word = in_.word(); !word.empty(); word = in_.word()) {
      std::int64_t index = 0;
      const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (code != std::errc() || (end != word.data() + word.size() && *end != '/') || index == 0)
        return wrong(quote(word) + " is no corner of a face; expected its number, from 1 on");
      const auto count = static_cast<std::int64_t>(polygons_.corners.size());
      const std::int64_t from_start = index > 0 ? index - 1 : count + index;
      if (from_start < 0)
        return wrong("corner " + std::to_string(index) + " of the " + std::to_string(count) + " so far");
      polygons_.corner_of.push_back(static_cast<std::uint32_t>(
          std::min<std::uint64_t>(static_cast<std::uint64_t>(from_start), kNowhere)));
    }
    polygons_.first.push_back(polygons_.corner_of.size());
    polygons_.place.push_back(line);
    return {};
  }

  Result<void> bare() {
    ++bare_;
    return {};
  }

  Statements in_;
  const std::string& name_;
  Polygons polygons_;
  std::uint64_t bare_ = 0;
};

}  // namespace

bool looks_like_obj(std::string_view bytes) {
  Statements in(bytes.substr(0, std::size_t{1} << 16));
  do {
    const std::string_view word = in.word();
    if (!word.empty())
      return word == "v" || word == "f" || is_one_of(word, kSkipped) || is_one_of(word, kFreeForm);
  } while (in.next());
  return false;
}

Result<Polygons> parse_obj(std::string_view bytes, const std::string& name) {
  return ObjReader(bytes, name).read();
}

}  // namespace tiltfeed::pathgen
