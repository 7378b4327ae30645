#pragma once
// A scripted controller of the Grbl family, written from the protocol, and a bench that runs a session
// against it in made-up time.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "daemon/protocol/grbl_session.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A controller as the protocol describes it. Knows nothing of the session.
class FakeGrbl {
 public:
  explicit FakeGrbl(int buffer = 128, bool identity = true) : buffer_(buffer), identity_(identity) {}

  std::string state = "Idle", replies, room = "15,128";  // room: figures of Bf:
  std::vector<std::string> lines;                        // taken, in order
  std::size_t unanswered = 0;  // bytes of lines that came and whose ok has not been heard
  std::size_t most_unanswered = 0;
  bool silent_status = false, withhold = false;
  bool offsets = true;  // WCO: in each report
  bool frozen = false;  // answers, and moves nothing
  bool checks = true;   // $C leads into check mode, or is answered only
  int executed_x = 0;   // of the lines G1X<whole number>
  int position = 0, polls = 0, holds = 0, resumes = 0, resets = 0;

  void receive(std::string_view bytes) {
    for (const char c : bytes) {
      if (c == '?') {
        ++polls;
        if (!silent_status)
          replies += "<" + state + "|MPos:" + std::to_string(position + executed_x) + ",0,0|Bf:" + room +
                     "|FS:0,0" + (offsets ? "|WCO:0,0,0" : "") + ">\r\n";
      } else if (c == '!') {
        ++holds;
        state = "Hold:0";
      } else if (c == '~') {
        ++resumes;
        state = "Idle";
      } else if (c == 0x18) {
        ++resets;
        state = "Idle";
        arrived_.clear();
        partial_.clear();
        replies += "\r\nGrbl 1.1h ['$' for help]\r\n";
      } else if (c == '\n') {
        ++unanswered;
        arrived_.push_back(std::move(partial_));
        partial_.clear();
      } else {
        ++unanswered;
        partial_ += c;
      }
      most_unanswered = std::max(most_unanswered, unanswered);
    }
    while (!withhold && !arrived_.empty() && arrived_.front() == "$I") work();
  }

  /// Takes the oldest line and answers it.
  bool work(const std::string& answer = "ok") {
    if (arrived_.empty()) return false;
    const std::string line = std::move(arrived_.front());
    arrived_.pop_front();
    pending_sizes_.push_back(line.size() + 1);
    if (line == "$I" && identity_) {
      replies += "[VER:1.1h.20190825:]\r\n[OPT:V,15," + std::to_string(buffer_) + "]\r\n";
      replies += answer + "\r\n";
      return true;
    }
    if (line != "$I") lines.push_back(line);
    if (line == "$C" && answer == "ok" && checks) state = "Check";
    if (line.starts_with("G1X") && answer == "ok" && !frozen && line.size() < 10)
      executed_x = std::stoi(line.substr(3));
    replies += answer + "\r\n";
    return true;
  }

  /// What the host has read by now counts as answered.
  void heard(std::string_view bytes) {
    for (std::size_t at = bytes.find("ok\r\n"); at != bytes.npos; at = bytes.find("ok\r\n", at + 1)) {
      unanswered -= pending_sizes_.front();
      pending_sizes_.pop_front();
    }
  }

  bool waiting() const { return !arrived_.empty(); }

 private:
  int buffer_;
  bool identity_;
  std::string partial_;
  std::deque<std::string> arrived_;
  std::deque<std::size_t> pending_sizes_;
};

/// Session, controller and clock.
struct GrblBench {
  explicit GrblBench(std::vector<std::string> program, FakeGrbl grbl = FakeGrbl(), GrblOptions given = {})
      : fake(std::move(grbl)), texts(std::move(program)), session(options(given), Time{0}) {}

  GrblOptions options(GrblOptions given) const {
    given.total = texts.size();
    for (std::size_t i = 0; i < texts.size(); ++i)
      if (texts[i].size() > given.longest) {
        given.longest = texts[i].size();
        given.longest_line = i + 1;
      }
    return given;
  }

  void feed() {
    while (session.wants_work()) {
      if (next == texts.size()) return session.end_of_program();
      Line line{next + 1, texts[next], texts[next] == "M0" || texts[next].starts_with("G10"),
                texts[next] == "M0", 0.0};
      if (texts[next].starts_with("G4P")) line.dwell = std::stod(texts[next].substr(3));
      session.push(std::move(line));
      ++next;
    }
  }
  /// Session to controller, everything.
  void talk() {
    feed();
    const std::string out(session.output(now));
    session.sent(out.size());
    fake.receive(out);
  }
  /// Controller to session, everything.
  void listen() {
    const std::string in = std::move(fake.replies);
    fake.replies.clear();
    fake.heard(in);
    session.receive(in, now);
  }
  void exchange(Time step = milliseconds(1)) {
    talk();
    listen();
    now += step;
  }
  void open() {
    for (int i = 0; i < 20 && is_opening(session.phase()); ++i) exchange();
    ASSERT_EQ(session.phase(), Phase::kRun) << session.error().message;
    talk();
  }
  void say(const std::string& text) { session.receive(text, now); }
  void finish(int limit = 100000) {
    for (int i = 0; i < limit && !is_final(session.phase()); ++i) {
      fake.work();
      exchange();
    }
  }

  FakeGrbl fake;
  std::vector<std::string> texts;
  std::size_t next = 0;
  Time now{0};
  GrblSession session;
};

inline std::vector<std::string> numbered(int count) {
  std::vector<std::string> lines;
  for (int i = 1; i <= count; ++i) lines.push_back("G1X" + std::to_string(i));
  return lines;
}

}  // namespace tiltfeed
