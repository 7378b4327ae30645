#include "cad/text/step_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace tiltfeed::cad {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '-' || is_digit(c);
}

enum class TokenKind { kEnd, kBroken, kWord, kReference, kNumber, kText, kSign };
struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string_view text;
};

/// Comments and blanks are left out. kBroken: a string, comment or binary that does not end.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}
  Token next() {
    if (!skip()) return {TokenKind::kBroken, {}};
    if (at_ >= text_.size()) return {};
    const std::size_t start = at_;
    const char c = text_[at_++];
    if (c == '\'' || c == '"') return quoted(start, c);
    if (c == '#') {
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
      return {at_ == start + 1 ? TokenKind::kSign : TokenKind::kReference, text_.substr(start, at_ - start)};
    }
    if (is_digit(c) || c == '+' || c == '-') {
      while (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.' || exponent())) ++at_;
      return {TokenKind::kNumber, text_.substr(start, at_ - start)};
    }
    if (is_word(c) || c == '!') {
      while (at_ < text_.size() && is_word(text_[at_])) ++at_;
      return {TokenKind::kWord, text_.substr(start, at_ - start)};
    }
    return {TokenKind::kSign, text_.substr(start, 1)};
  }
  std::uint64_t line() const {
    return 1 + static_cast<std::uint64_t>(
                   std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
  }

 private:
  bool exponent() const {
    const char c = text_[at_], before = text_[at_ - 1];
    if (c == 'E' || c == 'e') return true;
    return (c == '+' || c == '-') && (before == 'E' || before == 'e');
  }
  Token quoted(std::size_t start, char mark) {
    while (true) {
      const std::size_t end = text_.find(mark, at_);
      if (end == text_.npos) return {TokenKind::kBroken, {}};
      at_ = end + 1;
      if (mark == '"' || at_ >= text_.size() || text_[at_] != mark) break;
      ++at_;  // two marks stand for one
    }
    return {TokenKind::kText, text_.substr(start, at_ - start)};
  }
  bool skip() {
    while (at_ < text_.size()) {
      if (static_cast<unsigned char>(text_[at_]) <= ' ') {
        ++at_;
      } else if (text_.substr(at_, 2) == "/*") {
        const std::size_t end = text_.find("*/", at_ + 2);
        if (end == text_.npos) return at_ = text_.size(), false;
        at_ = end + 2;
      } else {
        return true;
      }
    }
    return true;
  }
  std::string_view text_;
  std::size_t at_ = 0;
};

std::uint64_t number_of(std::string_view reference) {
  std::uint64_t number = 0;
  std::from_chars(reference.data() + 1, reference.data() + reference.size(), number);
  return number;
}

/// Nothing where it is beyond a double.
std::optional<double> value_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc::result_out_of_range) return value;
  // Too small is as good as zero.
  const std::size_t e = text.find_first_of("eE");
  return e != text.npos && text.substr(e + 1).starts_with('-') ? std::optional(0.0) : std::nullopt;
}

class Check {
 public:
  Check(std::string_view text, const std::string& file) : tokens_(text), file_(file) {}

  Result<StepEntities> run() {
    if (auto done = read(); !done) return tl::unexpected(done.error());
    auto& types = found_.types;
    std::stable_sort(types.begin(), types.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < types.size(); ++i)
      if (types[i].first == types[i - 1].first)
        return wrong("#" + std::to_string(types[i].first) + " is there twice, as " + types[i - 1].second +
                     " and as " + types[i].second);
    for (const auto& [from, to] : references_)
      if (!there(to))
        return wrong(found_.name(from) + " refers to #" + std::to_string(to) + ", which is not there");
    if (types.empty()) return wrong("it has no entities");
    if (const std::uint64_t circle = in_circle(); circle > 0)
      return wrong(found_.name(circle) + " refers to itself, by way of others or not");
    return std::move(found_);
  }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return fail(Code::kInput, file_ + ": " + what + "; export the part again");
  }
  tl::unexpected<Error> cut_short() const {
    const std::string where =
        entity_ == 0 ? "" : " in #" + std::to_string(entity_) + (type_.empty() ? "" : " " + type_);
    return wrong("the STEP file is cut short" + where + ", at line " + std::to_string(tokens_.line()));
  }
  std::size_t index_of(std::uint64_t number) const {
    const auto at = std::lower_bound(found_.types.begin(), found_.types.end(), number,
                                     [](const auto& a, std::uint64_t b) { return a.first < b; });
    return static_cast<std::size_t>(at - found_.types.begin());
  }
  bool there(std::uint64_t number) const {
    const std::size_t at = index_of(number);
    return at < found_.types.size() && found_.types[at].first == number;
  }

  /// An entity in a circle of references; 0: none. Requires: all that is named is there.
  std::uint64_t in_circle() {
    std::stable_sort(references_.begin(), references_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    // Depth first, without recursion: chains are long.
    enum class Mark : char { kNew, kOpen, kDone };
    std::vector<Mark> marks(found_.types.size(), Mark::kNew);
    std::vector<std::pair<std::size_t, std::size_t>> way;  // an entity, and the next of its references
    const auto open = [&](std::size_t entity) {
      marks[entity] = Mark::kOpen;
      const auto at = std::lower_bound(references_.begin(), references_.end(), found_.types[entity].first,
                                       [](const auto& a, std::uint64_t b) { return a.first < b; });
      way.emplace_back(entity, static_cast<std::size_t>(at - references_.begin()));
    };
    for (std::size_t root = 0; root < marks.size(); ++root) {
      if (marks[root] == Mark::kNew) open(root);
      while (!way.empty()) {
        auto& [at, next] = way.back();
        if (next == references_.size() || references_[next].first != found_.types[at].first) {
          marks[at] = Mark::kDone;
          way.pop_back();
          continue;
        }
        const std::uint64_t to = references_[next++].second;
        const std::size_t other = index_of(to);
        if (marks[other] == Mark::kOpen) return to;
        if (marks[other] == Mark::kNew) open(other);
      }
    }
    return 0;
  }

  Result<void> read() {
    Token token = tokens_.next();
    if (token.text != "ISO-10303-21") return wrong("it does not begin with ISO-10303-21");
    bool header = true;
    while (true) {
      token = tokens_.next();
      if (token.kind == TokenKind::kEnd || token.kind == TokenKind::kBroken) return cut_short();
      if (token.text == "END-ISO-10303-21") return {};
      if (token.text == "DATA") header = false;
      if (token.kind == TokenKind::kReference && !header) {
        if (auto done = entity(number_of(token.text)); !done) return done;
      } else if (token.text == "FILE_SCHEMA") {
        schema_next_ = true;
      } else if (token.kind == TokenKind::kText && schema_next_) {
        schema_next_ = false;
        const std::string_view name = token.text.substr(1, token.text.size() - 2);
        found_.schema = std::string(name.substr(0, name.find_first_of(" {")));
      }
    }
  }

  /// From its number to the semicolon.
  Result<void> entity(std::uint64_t number) {
    entity_ = number, type_.clear();
    Token token = tokens_.next();
    const bool broken = token.kind == TokenKind::kEnd || token.kind == TokenKind::kBroken;
    if (!broken && token.text != "=")
      return wrong("#" + std::to_string(number) + " has no '=' after its number, at line " +
                   std::to_string(tokens_.line()));
    for (;; token = tokens_.next()) {
      switch (token.kind) {
        case TokenKind::kEnd:
        case TokenKind::kBroken:
          return cut_short();
        case TokenKind::kWord:
          if (type_.empty()) type_ = std::string(token.text);
          break;
        case TokenKind::kReference:
          references_.emplace_back(number, number_of(token.text));
          break;
        case TokenKind::kNumber: {
          const auto value = value_of(token.text);
          if (!value || (type_ == "CARTESIAN_POINT" && std::abs(*value) > kMaxStepCoordinate))
            return wrong("#" + std::to_string(number) + " " + type_ + ": " +
                         std::string(token.text.substr(0, 40)) + " is out of range, at line " +
                         std::to_string(tokens_.line()));
          break;
        }
        case TokenKind::kSign:
          if (token.text == ";") {
            found_.types.emplace_back(number, type_);
            entity_ = 0;
            return {};
          }
          break;
        case TokenKind::kText:
          break;
      }
    }
  }

  Tokens tokens_;
  const std::string& file_;
  StepEntities found_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> references_;
  std::uint64_t entity_ = 0;
  std::string type_;
  bool schema_next_ = false;
};

}  // namespace

std::string StepEntities::name(std::uint64_t number) const {
  const auto at = std::lower_bound(types.begin(), types.end(), number,
                                   [](const auto& a, std::uint64_t b) { return a.first < b; });
  const std::string text = "#" + std::to_string(number);
  return at != types.end() && at->first == number && !at->second.empty() ? text + " " + at->second : text;
}

Result<StepEntities> check_step_text(std::string_view text, const std::string& file) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return Check(text, file).run();
}

}  // namespace tiltfeed::cad
