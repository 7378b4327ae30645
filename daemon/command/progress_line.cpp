#include "daemon/command/progress_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "daemon/command/interrupt.h"

namespace tiltfeed::daemon {

namespace {
constexpr std::chrono::milliseconds kRedraw{100};
constexpr int kFileLine = 80;
}  // namespace

ProgressLine::ProgressLine(const std::string& file) : terminal_(isatty(STDERR_FILENO) == 1) {
  if (!file.empty()) file_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
}

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
