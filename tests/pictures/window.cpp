// Character counting: what is in a controller's receive buffer while a Grbl session streams a program, and
// when each line was sent and acknowledged.

#include <chrono>
#include <cmath>
#include <deque>

#include "daemon/protocol/grbl_session.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/svg.h"

namespace tiltfeed::pictures {
using namespace config;
using namespace daemon;
namespace {

constexpr int kBuffer = 128;             // bytes, Grbl 1.1
constexpr double kBytesPerStep = 1.152;  // a step is 0.1 ms, the line has 115200 baud
constexpr int kPlanner = 4;              // blocks
constexpr std::size_t kLines = 40;

/// A controller of the Grbl family by a script: line i of the program takes `takes` steps of 0.1 ms.
class Controller {
 public:
  void receive(char byte) {
    if (byte == '?') {
      replies += "<" + std::string(moving_.empty() ? "Idle" : "Run") + "|MPos:" + std::to_string(done_) +
                 ",0,0|Bf:15,128|FS:0,0|WCO:0,0,0>\r\n";
      return;
    }
    ++held;
    partial_ += byte;
    if (byte == '\n') lines_.push_back(std::move(partial_)), partial_.clear();
  }

  void step() {
    if (!moving_.empty() && --moving_.front() <= 0) moving_.pop_front(), ++done_;
    if (lines_.empty()) return;
    const std::string line = lines_.front();
    if (line == "G4P0\n" && !moving_.empty()) return;
    if (line.starts_with("G1") && moving_.size() == kPlanner) return;
    if (line.starts_with("G1")) moving_.push_back(takes(taken_++));
    if (line == "$I\n") replies += "[VER:1.1h.20190825:]\r\n[OPT:V,15,128]\r\n";
    replies += "ok\r\n";
    held -= line.size();
    lines_.pop_front();
  }

  std::size_t held = 0;  ///< bytes in the receive buffer
  std::string replies;

 private:
  static int takes(std::size_t line) { return line % 13 < 5 ? 20 : 90; }
  std::string partial_;
  std::deque<std::string> lines_;
  std::deque<int> moving_;
  std::size_t taken_ = 0, done_ = 0;
};

struct Sent {
  double from = 0.0, to = 0.0;  ///< its last byte, its ok; ms
};
struct Run {
  Line window, held;  ///< bytes over ms
  std::vector<Sent> lines;
  double end = 0.0;
  std::size_t most = 0;
};

std::string text_of(std::size_t i) {
  std::string text = "G1X" + std::to_string(i + 1);
  if (i % 3 == 1) text += "Y0A12.5C" + std::to_string(100 + i);
  if (i % 3 == 2) text += "C" + std::to_string(i);
  return text;
}

Result<Run> stream() {
  GrblOptions options;
  options.total = kLines, options.longest = kMaxLine / 4, options.longest_line = 1;
  GrblSession session(options, Time{0});
  Controller controller;
  Run run;
  std::size_t next = 0;
  double credit = 0.0;
  int begun = -1;
  for (int step = 0; session.phase() != Phase::kDone; ++step) {
    const Time now = std::chrono::microseconds(100 * step);
    if (is_final(session.phase()) || step > 100000) return fail(Code::kLink, session.error().message);
    while (session.wants_work()) {
      if (next == kLines) {
        session.end_of_program();
        break;
      }
      session.push({next + 1, text_of(next), false, false, 0.0});
      ++next;
    }
    for (credit = std::min(credit + kBytesPerStep, 2.0); credit >= 1.0; credit -= 1.0) {
      const std::string_view out = session.output(now);
      if (out.empty()) break;
      controller.receive(out.front());
      session.sent(1);
    }
    controller.step();
    const std::string replies = std::move(controller.replies);
    controller.replies.clear();
    session.receive(replies, now);
    if (begun < 0 && session.phase() == Phase::kRun) begun = step;
    if (begun < 0) continue;
    const SendState state = session.state();
    const double ms = 0.1 * (step - begun);
    run.lines.resize(kLines);
    for (std::size_t i = 0; i < state.sent; ++i)
      if (run.lines[i].from == 0.0) run.lines[i].from = ms;
    for (std::size_t i = 0; i < state.acknowledged; ++i)
      if (run.lines[i].to == 0.0) run.lines[i].to = ms;
    run.window.push_back({ms, static_cast<double>(session.in_flight_bytes())});
    run.held.push_back({ms, static_cast<double>(controller.held)});
    run.most = std::max(run.most, session.in_flight_bytes());
    if (state.acknowledged < kLines) run.end = ms;
  }
  return run;
}

/// Only the corners of a line of steps.
Line corners(const Line& line, double end) {
  Line out;
  for (const At p : line) {
    if (p.x > end) break;
    if (!out.empty() && out.back().y == p.y) continue;
    if (!out.empty()) out.push_back({p.x, out.back().y});
    out.push_back(p);
  }
  out.push_back({end, out.back().y});
  return out;
}

}  // namespace

Result<void> draw_window(const std::string& file) {
  const auto run = stream();
  if (!run) return tl::unexpected(run.error());
  const double end = std::ceil(run->end / 20.0 + 0.01) * 20.0;

  Svg svg(900, 560, "Bytes on their way to a Grbl controller, and its lines");
  const Plot bytes{{60, 70}, 820, 210, {0, 0}, {end, 140}};
  bytes.grid(svg, {20, 20}, "time, ms", "bytes");
  Line held = corners(run->held, end);
  held.push_back({end, 0}), held.push_back({0, 0});
  svg.path(bytes.at(held), "fill=\"#bbdfc5\"", true);
  svg.path(bytes.at(corners(run->window, end)), "stroke=\"#1d4ed8\" stroke-width=\"1.5\"");
  svg.line(bytes.at({0, kBuffer - 1}), bytes.at({end, kBuffer - 1}), "stroke=\"#c2410c\" stroke-width=\"2\"");

  const Plot lines{{60, 350}, 820, 170, {0, -static_cast<double>(kLines) - 1}, {end, 0}};
  for (double t = 0; t <= end; t += 20) {
    svg.line(lines.at({t, lines.low.y}), lines.at({t, 0}), "stroke=\"#ddd\"");
    svg.text({lines.at({t, 0}).x, 536}, fixed(t, 0), "text-anchor=\"middle\" font-size=\"11\"");
  }
  for (std::size_t i = 0; i < kLines; ++i) {
    const double y = -static_cast<double>(i) - 1;
    svg.line(lines.at({run->lines[i].from, y}), lines.at({run->lines[i].to, y}),
             "stroke=\"#1d4ed8\" stroke-width=\"2.5\"");
    if ((i + 1) % 10 == 0 || i == 0)
      svg.text({lines.corner.x - 6, lines.at({0, y}).y + 4}, std::to_string(i + 1),
               "text-anchor=\"end\" font-size=\"11\"");
  }
  svg.text({30, 342}, "line of the program: from its first byte to its ok");
  svg.text({880, 552}, "time, ms", "text-anchor=\"end\"");
  legend(svg, {60, 24}, "stroke=\"#1d4ed8\" stroke-width=\"1.5\"",
         "lines on their way, as the session counts: " + std::to_string(run->most) + " at most");
  svg.box({450, 13}, 24, 12, "fill=\"#bbdfc5\"");
  svg.text({480, 24}, "in the controller's buffer");
  legend(svg, {665, 24}, "stroke=\"#c2410c\" stroke-width=\"2\"", "window: buffer less one, 127");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
