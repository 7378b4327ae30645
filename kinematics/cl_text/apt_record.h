#pragma once
// APT text as records: a word, and behind the slash its numbers and words. A `$` at a line's end goes on in
// the next line, `$$` opens a comment.

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tiltfeed {

/// A place in the text, 1-based.
struct AptPlace {
  std::uint32_t line = 0, column = 0;
};

/// What is wrong with a record, and where in it. Line 0: the whole record.
struct AptMistake {
  std::string what;
  AptPlace place;
};
using AptVerdict = std::optional<AptMistake>;
inline AptMistake mistake(std::string what, AptPlace place = {}) { return {std::move(what), place}; }

/// The number that a word is, with E or D before an exponent; NaN for "nan", "inf" and beyond a double;
/// nothing when it is no number.
std::optional<double> apt_number(std::string_view text);

struct AptRecord {
  std::string word;                ///< upper case
  std::vector<std::string> words;  ///< behind the slash, upper case, without blanks; "" where one is missing
  std::vector<AptPlace> places;    ///< of `words`
  std::string text;                ///< of PARTNO, PPRINT and their kin: as it stands
  AptPlace place;                  ///< of `word`

  bool has(std::string_view name) const;
  /// All of `words` as numbers; wrong: one that is missing, none, infinite, or one too many.
  AptVerdict numbers(std::span<double> values, std::size_t& count) const;
  std::optional<double> first_number() const;
  /// Of `words`, how many are numbers, and the place of the second.
  std::size_t count_numbers(AptPlace* second = nullptr) const;
  /// The second of two numbers with no word between them: 1,5 may be 1.5.
  std::optional<AptPlace> number_behind_number() const;
  std::optional<double> number_after(std::string_view name) const;
};

class AptRecords {
 public:
  explicit AptRecords(std::istream& in) : in_(in) {}
  /// False at the text's end.
  bool next(AptRecord& record);
  std::uint32_t line() const { return line_; }

 private:
  /// Where a line's share of `text_` begins.
  struct Piece {
    std::size_t offset = 0;
    AptPlace place;
  };
  AptPlace place_of(std::size_t offset) const;
  void split(AptRecord& record) const;

  std::istream& in_;
  std::uint32_t line_ = 0;
  std::string text_, raw_;
  std::vector<Piece> pieces_;
};

}  // namespace tiltfeed
