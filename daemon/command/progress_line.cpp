#include "daemon/command/progress_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "daemon/command/interrupt.h"

namespace tiltfeed::daemon {

namespace {
constexpr std::chrono::milliseconds kRedraw{100};
constexpr int kFileLine = 80;

/// An empty file, or a line as write_file_line() leaves it.
bool holds_progress(int file) {
  char text[kFileLine + 1];
  const ssize_t size = ::pread(file, text, sizeof text, 0);
  if (size == 0) return true;
  return size == kFileLine && text[kFileLine - 1] == '\n' && text[3] == ' ' && text[2] >= '0' &&
         text[2] <= '9';
}

}  // namespace

Result<int> open_progress(const std::string& file, std::vector<config::NamedFile> outputs) {
  if (file.empty()) return -1;
  outputs.push_back({"--progress", file});
  if (const auto fits = config::check_outputs(outputs, {}); !fits) return tl::unexpected(fits.error());
  const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (made < 0) return fail(Code::kIo, "--progress " + file + ": " + std::strerror(errno));
  if (holds_progress(made)) return made;
  ::close(made);
  return fail(Code::kUsage,
              "--progress " + file + " is there and holds something else; name a file that is not there");
}

ProgressLine::ProgressLine(int file) : terminal_(isatty(STDERR_FILENO) == 1), file_(file) {}

bool ProgressLine::show(const std::string& text, double fraction) {
  const auto now = std::chrono::steady_clock::now();
  const bool fresh = text != text_;
  if (fresh || ((terminal_ || file_ >= 0) && now - shown_ > kRedraw)) {
    if (terminal_)
      std::fprintf(stderr, "\r\033[K%s %3.0f %%", text.c_str(), fraction * 100.0);
    else if (fresh)
      std::fprintf(stderr, "%s\n", text.c_str());
    write_file_line(text, fraction);
    text_ = text;
    shown_ = now;
  }
  return !interrupted();
}

/// One write of one length: who reads sees a whole line. A file that takes nothing is no reason to stop.
void ProgressLine::write_file_line(const std::string& text, double fraction) const {
  if (file_ < 0) return;
  char line[kFileLine + 1];
  std::snprintf(line, sizeof line, "%3.0f %-*.*s", fraction * 100.0, kFileLine - 5, kFileLine - 5,
                text.c_str());
  line[kFileLine - 1] = '\n';
  if (::pwrite(file_, line, kFileLine, 0) < 0) return;
}

void ProgressLine::note(const std::string& text) {
  std::fprintf(stderr, terminal_ ? "\r\033[K%s\n" : "%s\n", text.c_str());
}

ProgressLine::~ProgressLine() {
  if (file_ >= 0) ::close(file_);
  if (terminal_ && !text_.empty()) std::fprintf(stderr, "\r\033[K");
}

}  // namespace tiltfeed::daemon
