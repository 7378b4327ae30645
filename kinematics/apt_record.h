#pragma once
// APT text as records: a word, and behind the slash its numbers and words. A `$` at a line's end goes on in
// the next line, `$$` opens a comment.

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tiltfeed {

struct AptRecord {
  std::string word;                ///< upper case
  std::vector<std::string> words;  ///< behind the slash, upper case, without blanks; "" where one is missing
  std::string text;                ///< of PARTNO, PPRINT and their kin: as it stands
  std::uint32_t line = 0;          ///< its first, 1-based

  bool has(const std::string& name) const;
  /// All of `words` as numbers; what is wrong as text: one that is missing, none, infinite, or one too many.
  std::optional<std::string> numbers(std::span<double> values, std::size_t& count) const;
  std::optional<double> first_number() const;
  std::optional<double> number_after(const std::string& name) const;
};

/// The word asks for another motion than straight lines to the points that follow (CYCLE, CIRCLE, CUTCOM
/// ...).
bool bends_path(const AptRecord& record);
/// The word informs people or other programs, or ends what `bends_path` knows.
bool only_informs(const AptRecord& record);

class AptRecords {
 public:
  explicit AptRecords(std::istream& in) : in_(in) {}
  /// False at the text's end.
  bool next(AptRecord& record);
  std::uint32_t line() const { return line_; }

 private:
  std::istream& in_;
  std::uint32_t line_ = 0;
  std::string text_, raw_;
};

}  // namespace tiltfeed
