#pragma once
// The lines of a program's text.

#include <algorithm>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace tiltfeed::sim {

/// The lines of a stream without their ends (LF, CR LF or CR), each good until the next; the stream is read
/// ahead.
class Lines {
 public:
  explicit Lines(std::istream& in) : in_(in) {}
  std::optional<std::string_view> next() {
    for (std::size_t searched = begin_;;) {
      const auto ends = [](char c) { return c <= '\r' && (c == '\n' || c == '\r'); };
      const char* const found = std::find_if(text_.data() + searched, text_.data() + end_, ends);
      const std::size_t end = static_cast<std::size_t>(found - text_.data());
      // A CR that came last may be half of a CR LF.
      const bool known = end < end_ && (text_[end] == '\n' || end + 1 < end_);
      if (known || (!in_ && begin_ < end_)) {
        const std::string_view line(text_.data() + begin_, end - begin_);
        const bool both = end + 1 < end_ && text_[end] == '\r' && text_[end + 1] == '\n';
        begin_ = std::min(end + (both ? 2 : 1), end_);
        return line;
      }
      if (!in_) return std::nullopt;
      searched = end - begin_;
      read_on();
    }
  }

 private:
  /// What is left comes to the front, more behind it.
  void read_on() {
    std::copy(text_.begin() + static_cast<std::ptrdiff_t>(begin_),
              text_.begin() + static_cast<std::ptrdiff_t>(end_), text_.begin());
    end_ -= begin_, begin_ = 0;
    if (text_.size() < end_ + kReadAhead) text_.resize(end_ + kReadAhead);
    in_.read(text_.data() + end_, kReadAhead);
    end_ += static_cast<std::size_t>(in_.gcount());
  }

  static constexpr std::size_t kReadAhead = 1 << 16;
  std::istream& in_;
  std::string text_;
  std::size_t begin_ = 0, end_ = 0;  ///< of what is not given yet
};

}  // namespace tiltfeed::sim
