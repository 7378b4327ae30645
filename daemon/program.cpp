#include "daemon/program.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>

#include "daemon/words.h"

namespace tiltfeed {

struct Program::File {
  int fd = -1;
  struct stat status {};
};

void Program::CloseFile::operator()(File* file) const {
  if (file->fd >= 0) ::close(file->fd);
  delete file;
}

namespace {

constexpr char kReset = 0x18;               // a live byte of the Grbl family
constexpr unsigned char kFirstHigh = 0x80;  // overrides and jog cancel lie from here up
constexpr std::string_view kHeaderMark = "TILTFEED";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_live(char c) {
  return c == '!' || c == '~' || c == '?' || c == kReset || static_cast<unsigned char>(c) >= kFirstHigh;
}

/// No control has a G or M code from here on.
constexpr double kLargestCode = 1000.0;

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
    const std::optional<Word> word = take_word(rest);
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

Result<Program> Program::open(const std::string& path) {
  Program program;
  program.path_ = path;
  program.file_.reset(new File);
  program.file_->fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (program.file_->fd < 0 || ::fstat(program.file_->fd, &program.file_->status) != 0)
    return fail(Code::kIo, path + ": cannot be opened: " + std::strerror(errno));
  if (!S_ISREG(program.file_->status.st_mode))
    return fail(Code::kInput,
                path + ": is not a regular file; a program is read twice, so save it to a file");
  program.window_ = std::make_unique<char[]>(kMaxRawLine);
  return program;
}

tl::unexpected<Error> Program::bad_line(const std::string& what) const {
  return fail(Code::kInput, path_ + ":" + std::to_string(number_) + ": " + what);
}

Result<void> Program::check_unchanged() const {
  struct stat now {};
  const struct stat& was = file_->status;
  if (::fstat(file_->fd, &now) != 0) return fail(Code::kIo, path_ + ": " + std::strerror(errno));
  if (now.st_size != was.st_size || now.st_mtim.tv_sec != was.st_mtim.tv_sec ||
      now.st_mtim.tv_nsec != was.st_mtim.tv_nsec)
    return fail(Code::kIo, path_ + ": was changed while it was being sent; send a copy that nobody edits");
  return {};
}

Result<void> Program::rewind() {
  if (::lseek(file_->fd, 0, SEEK_SET) != 0) return fail(Code::kIo, path_ + ": " + std::strerror(errno));
  begin_ = end_ = 0;
  number_ = sent_ = 0;
  at_end_ = finished_ = false;
  return check_unchanged();
}

/// The next line of the file as it stands there, without its LF.
Result<bool> Program::read_raw(std::string_view& raw) {
  std::size_t searched = 0;
  for (;;) {
    const char* start = window_.get() + begin_;
    if (const void* lf = std::memchr(start + searched, '\n', end_ - begin_ - searched)) {
      const auto size = static_cast<std::size_t>(static_cast<const char*>(lf) - start);
      raw = {start, size};
      begin_ += size + 1;
      ++number_;
      return true;
    }
    searched = end_ - begin_;
    if (at_end_) {
      if (searched == 0) return false;
      raw = {start, searched};
      begin_ = end_;
      ++number_;
      return true;
    }
    if (searched == kMaxRawLine) {
      ++number_;
      return bad_line("is longer than " + std::to_string(kMaxRawLine) + " bytes; is this a program?");
    }
    std::memmove(window_.get(), start, searched);
    begin_ = 0;
    end_ = searched;
    const ssize_t count = ::read(file_->fd, window_.get() + end_, kMaxRawLine - end_);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(Code::kIo, path_ + ": " + std::strerror(errno));
    at_end_ = count == 0;
    end_ += static_cast<std::size_t>(count);
  }
}

/// Drops comments, blanks and control characters, makes letters upper case.
Result<void> Program::clean(std::string_view raw, std::string& text) {
  text.clear();
  if (number_ == 1 && raw.starts_with(kByteOrderMark)) raw.remove_prefix(kByteOrderMark.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const char c = raw[i];
    if (c > ' ' && c <= '}') {
      if (c == ';') break;
      if (c == '(') {
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
      text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    } else if (is_live(c)) {
      constexpr char kHex[] = "0123456789ABCDEF";
      const auto byte = static_cast<unsigned char>(c);
      return bad_line("column " + std::to_string(i + 1) + ": byte 0x" + kHex[byte >> 4] + kHex[byte & 15] +
                      " acts at once on a controller; it may stand in comments only");
    }
  }
  if (text.size() > kMaxLine)
    return bad_line(std::to_string(text.size()) + " bytes without comments; no controller takes more than " +
                    std::to_string(kMaxLine) + ": shorten the line");
  return {};
}

Result<bool> Program::next(Line& line) {
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

Result<ProgramFacts> Program::survey() {
  ProgramFacts facts;
  Line line;
  for (;;) {
    const Result<bool> more = next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    ++facts.lines;
    facts.bytes += line.text.size() + 1;
    if (line.text.size() > facts.longest) {
      facts.longest = line.text.size();
      facts.longest_line = line.number;
    }
  }
  facts.header = header_;
  if (facts.lines == 0) return fail(Code::kInput, path_ + ": has no line to send");
  if (const Result<void> back = rewind(); !back) return tl::unexpected<Error>(back.error());
  return facts;
}

}  // namespace tiltfeed
