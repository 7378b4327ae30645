#include "daemon/progress_line.h"

#include <unistd.h>

#include <cstdio>

#include "daemon/interrupt.h"

namespace tiltfeed {

namespace {
constexpr std::chrono::milliseconds kRedraw{100};
}

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

bool ProgressLine::show(const std::string& text, double fraction) {
  const auto now = std::chrono::steady_clock::now();
  const bool fresh = text != text_;
  if (fresh || (terminal_ && now - shown_ > kRedraw)) {
    if (terminal_)
      std::fprintf(stderr, "\r\033[K%s %3.0f %%", text.c_str(), fraction * 100.0);
    else
      std::fprintf(stderr, "%s\n", text.c_str());
    text_ = text;
    shown_ = now;
  }
  return !interrupted();
}

void ProgressLine::note(const std::string& text) {
  std::fprintf(stderr, terminal_ ? "\r\033[K%s\n" : "%s\n", text.c_str());
}

ProgressLine::~ProgressLine() {
  if (terminal_ && !text_.empty()) std::fprintf(stderr, "\r\033[K");
}

}  // namespace tiltfeed
