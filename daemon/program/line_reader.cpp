#include "daemon/program/line_reader.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "daemon/program/numeric_block.h"

namespace tiltfeed::daemon {

namespace {

constexpr char kReset = 0x18;               // a live byte of the Grbl family
constexpr unsigned char kFirstHigh = 0x80;  // overrides and jog cancel lie from here up
constexpr std::string_view kHeaderMark = "TILTFEED";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_live(char c) {
  return c == '!' || c == '~' || c == '?' || c == kReset || static_cast<unsigned char>(c) >= kFirstHigh;
}

/// Some programs and tapes end lines or pages with these: dropped, they would make one line of two.
bool ends_lines_elsewhere(char c) { return c == '\v' || c == '\f' || (c >= 0x1C && c <= 0x1E); }

std::string hex(char c) {
  constexpr char kHex[] = "0123456789ABCDEF";
  const auto byte = static_cast<unsigned char>(c);
  return {'0', 'x', kHex[byte >> 4], kHex[byte & 15]};
}

constexpr const char* kOtherWords =
    "' keeps its meaning with brackets and blanks alone, which no link sends: programs of such a control "
    "(siemens, heidenhain) go to it as files, by its own ways; for this link plan or post with another "
    "dialect "
    "(program.dialect, post --dialect)";

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Where a name of two letters or more begins that a bracket at `open` belongs to: CYCLE800(, DC(. None:
/// npos.
std::size_t call_before(std::string_view raw, std::size_t open) {
  std::size_t at = open;
  while (at > 0 && is_digit(raw[at - 1])) --at;
  const std::size_t end = at;
  while (at > 0 && is_letter(raw[at - 1])) --at;
  return end - at < 2 ? raw.npos : at;
}

std::string name_at_end(std::string_view text) {
  std::size_t at = text.size();
  while (at > 0 && is_letter(text[at - 1])) --at;
  return std::string(text.substr(at));
}

std::string name_at_begin(std::string_view text) {
  return std::string(text.substr(
      0, static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_letter) - text.begin())));
}

/// A blank between `text`, which is sent, and what follows parts two names, or a name and a word. Messages to
/// people (M117) and names in <> may lose their blanks.
bool parts_names(std::string_view text, std::string_view rest) {
  if (text.empty() || !is_letter(text.back())) return false;
  const std::size_t first = text.front() == 'N' ? text.find_first_not_of("0123456789", 1) : 0;
  if (first < text.size() && text[first] == 'M') return false;
  if (text.rfind('<') != text.npos && text.find('>', text.rfind('<')) == text.npos) return false;
  return name_at_end(text).size() > 1 || name_at_begin(rest).size() > 1;
}

/// Tenths of a code's number, so 281 is G28.1; -1 where it cannot be one.
int tenths(double value) {
  return value >= 0.0 && value < kLargestCode ? static_cast<int>(value * 10.0 + 0.5) : -1;
}

bool waits_for_operator(char letter, double value) {
  return letter == 'M' && (tenths(value) == 0 || tenths(value) == 10 || tenths(value) == 60);
}

/// Codes that write to EEPROM, during which received bytes are lost.
bool writes_settings(char letter, double value) {
  return letter == 'G' && (tenths(value) == 100 || tenths(value) == 281 || tenths(value) == 301);
}

/// Sets alone, waits and dwell; true when the line ends the program. Lines that are not plain words are left
/// to the controller, which knows its own language.
bool read_codes(Line& line) {
  line.alone = line.waits = false;
  line.dwell = 0.0;
  bool ends = false, dwells = false;
  double p = 0.0;
  std::string_view rest = line.text;
  if (rest.find('M') == rest.npos && rest.find("G4") == rest.npos && rest.find("G04") == rest.npos &&
      rest.find("G10") == rest.npos && rest.find("G28") == rest.npos && rest.find("G30") == rest.npos)
    return false;
  while (!rest.empty()) {
    const std::optional<GcodeWord> word = take_word(rest);
    if (!word) return ends;
    line.waits = line.waits || waits_for_operator(word->letter, word->value);
    line.alone = line.alone || line.waits || writes_settings(word->letter, word->value);
    if (word->letter == 'M' && (word->value == 2.0 || word->value == 30.0)) ends = true;
    if (word->letter == 'G' && word->value == 4.0) dwells = true;
    if (word->letter == 'P') p = word->value;
    if (dwells) line.dwell = p;
  }
  return ends;
}

}  // namespace

Result<LineReader> LineReader::open(const std::string& path) {
  Result<ProgramFile> file = ProgramFile::open(path);
  if (!file) return tl::unexpected<Error>(file.error());
  LineReader program(std::move(*file));
  program.path_ = path;
  program.window_ = std::make_unique<char[]>(kMaxRawLine + ProgramFile::kPiece);
  return program;
}

tl::unexpected<Error> LineReader::bad_line(const std::string& what) const {
  return fail(Code::kInput, path_ + ":" + std::to_string(number_) + ": " + what);
}

Result<void> LineReader::rewind() {
  begin_ = end_ = 0;
  number_ = sent_ = 0;
  at_end_ = finished_ = after_cr_ = false;
  return file_.rewind();
}

/// The next line of the file as it stands there, without its end: LF, CR LF, or CR alone.
Result<bool> LineReader::read_raw(std::string_view& raw) {
  std::size_t searched = 0;
  for (;;) {
    if (after_cr_ && begin_ < end_) {
      if (window_[begin_] == '\n') ++begin_;
      after_cr_ = false;
    }
    const char* start = window_.get() + begin_;
    const std::size_t size = end_ - begin_;
    std::size_t at = searched;
    while (at < size && start[at] != '\n' && start[at] != '\r') ++at;
    if (std::min(at, size) > kMaxRawLine || (at == size && size == kMaxRawLine && !at_end_)) {
      ++number_;
      return bad_line("is longer than " + std::to_string(kMaxRawLine) + " bytes; is this a program?");
    }
    if (at < size || (at_end_ && size > 0)) {
      raw = {start, at};
      after_cr_ = at < size && start[at] == '\r';
      begin_ += std::min(at + 1, size);
      ++number_;
      return true;
    }
    if (at_end_) return false;
    searched = size;
    std::memmove(window_.get(), start, searched);
    begin_ = 0;
    end_ = searched;
    const Result<std::size_t> count = file_.read(window_.get() + end_);
    if (!count) return tl::unexpected<Error>(count.error());
    at_end_ = *count < ProgramFile::kPiece;
    end_ += *count;
  }
}

/// Drops comments, blanks and control characters, makes letters upper case.
/// What this would take out of the words of a Sinumerik or a Heidenhain is an error: CYCLE800 without its
/// brackets turns no plane.
Result<void> LineReader::clean(std::string_view raw, std::string& text) {
  text.clear();
  std::size_t parted = raw.npos;  // by such a byte, after text
  if (number_ == 1 && raw.starts_with(kByteOrderMark)) raw.remove_prefix(kByteOrderMark.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const char c = raw[i];
    if (c > ' ' && c <= '}') {
      if (c == ';') break;
      if (c == '(') {
        if (const std::size_t call = call_before(raw, i); call != raw.npos)
          return bad_line("column " + std::to_string(call + 1) + ": '" +
                          std::string(raw.substr(call, i + 1 - call)) + kOtherWords);
        const std::size_t close = raw.find(')', i);
        if (close == raw.npos) return bad_line("column " + std::to_string(i + 1) + ": comment without ')'");
        const std::string_view comment = raw.substr(i + 1, close - i - 1);
        if (header_.empty() && comment.starts_with(kHeaderMark))
          for (const char h : comment)
            if (h >= ' ' && h < 0x7F) header_ += h;
        i = close;
        continue;
      }
      if (c == '!' || c == '?' || c == '$' || (c == '/' && text.empty()))
        return bad_line("column " + std::to_string(i + 1) + ": '" + c +
                        (c == '/' ? "' (block delete) is ambiguous; remove the line or the '/'"
                                  : "' is a command to the controller, not part of a program; remove it"));
      if (parted != raw.npos)
        return bad_line("column " + std::to_string(parted + 1) + ": byte " + hex(raw[parted]) +
                        " between two words ends a line elsewhere, but not here: put a line feed there");
      const bool blank = i > 0 && raw[i - 1] == ' ';
      if (blank && is_letter(c) && parts_names(text, raw.substr(i)))
        return bad_line("column " + std::to_string(i + 1) + ": '" + name_at_end(text) + ' ' +
                        name_at_begin(raw.substr(i)) + kOtherWords);
      text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    } else if (is_live(c)) {
      return bad_line("column " + std::to_string(i + 1) + ": byte " + hex(c) +
                      " acts at once on a controller; it may stand in comments only");
    } else if (ends_lines_elsewhere(c) && !text.empty() && parted == raw.npos) {
      parted = i;
    }
  }
  if (text.size() > kMaxLine)
    return bad_line(std::to_string(text.size()) + " bytes without comments; no controller takes more than " +
                    std::to_string(kMaxLine) + ": shorten the line");
  return {};
}

Result<bool> LineReader::next(Line& line) {
  while (!finished_) {
    std::string_view raw;
    const Result<bool> more = read_raw(raw);
    if (!more) return more;
    if (!*more) break;
    if (const Result<void> cleaned = clean(raw, line.text); !cleaned)
      return tl::unexpected<Error>(cleaned.error());
    if (line.text.empty()) continue;
    if (line.text.front() == '%') {
      if (sent_ > 0) break;  // the tape's end mark: what follows is not program
      continue;
    }
    line.number = number_;
    finished_ = read_codes(line);
    ++sent_;
    return true;
  }
  finished_ = true;
  return false;
}

Result<ProgramFacts> LineReader::survey() {
  file_.keep();
  ProgramFacts facts;
  Line line;
  for (;;) {
    const Result<bool> more = next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    ++facts.lines;
    facts.waits += line.waits;
    facts.bytes += line.text.size() + 1;
    if (line.text.size() > facts.longest) {
      facts.longest = line.text.size();
      facts.longest_line = line.number;
    }
  }
  facts.header = header_;
  if (facts.lines == 0) return fail(Code::kInput, path_ + ": has no line to send");
  const auto hash = file_.finish();
  if (!hash) return tl::unexpected<Error>(hash.error());
  facts.hash = *hash;
  if (const Result<void> back = rewind(); !back) return tl::unexpected<Error>(back.error());
  return facts;
}

}  // namespace tiltfeed::daemon
