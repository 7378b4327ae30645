#include "sim/motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/forward.h"

namespace tiltfeed::sim {
namespace {

// A word printed at the very limit must pass although the limit went through binary fractions.
constexpr double kLimitSlack = 1e-9;

double nearest_to_zero(double min, double max) { return std::clamp(0.0, min, std::max(min, max)); }

/// Seconds for `way` at `velocity` per minute; a velocity of zero states no bound.
double axis_time(double way, double velocity) {
  return velocity > 0.0 ? std::abs(way) / velocity * 60.0 : 0.0;
}

std::optional<std::string> outside_travel(char letter, double value, double min, double max) {
  if (value < min - kLimitSlack)
    return std::string(1, letter) + " " + std::to_string(value) + " is below its travel of " +
           std::to_string(min);
  if (value > max + kLimitSlack)
    return std::string(1, letter) + " " + std::to_string(value) + " is above its travel of " +
           std::to_string(max);
  return std::nullopt;
}

}  // namespace

Motion::Motion(MachineModel machine, Setup setup, std::size_t slots, Sink sink)
    : machine_(std::move(machine)), setup_(setup), slots_(slots), sink_(std::move(sink)) {
  assert(slots_ >= 1);
  const MachineModel& m = machine_;
  at_ = {nearest_to_zero(m.x.min, m.x.max), nearest_to_zero(m.y.min, m.y.max),
         nearest_to_zero(m.z.min, m.z.max), nearest_to_zero(m.tilt.min, m.tilt.max),
         nearest_to_zero(m.rotary.min, m.rotary.max)};
}

void Motion::push(const Block& block) {
  assert(free_slots() > 0);
  if (queue_.empty() && in_program_ && !held_) totals_.starved += now_ - idle_since_;
  queue_.push_back(block);
  start_next();
}

void Motion::advance(double now) {
  assert(now >= now_);
  while (running_ && !held_ && end() <= now) {
    now_ = std::max(now_, end());
    finish();
  }
  now_ = now;
}

std::optional<double> Motion::next_event() const {
  if (!running_ || held_) return std::nullopt;
  return std::max(now_, end());
}

void Motion::hold() {
  if (held_) return;
  account();
  if (queue_.empty() && in_program_) totals_.starved += now_ - idle_since_;
  held_ = true;
}

void Motion::resume() {
  if (!held_) return;
  held_ = false;
  since_ = now_;
  idle_since_ = now_;
  start_next();
}

void Motion::stop() {
  account();
  at_ = position();
  queue_.clear();
  running_ = held_ = in_program_ = false;
  fraction_ = duration_ = 0.0;
  spindle_ = 0.0;
}

void Motion::set_override(int& which, int percent) {
  account();
  which = percent;
  if (running_) duration_ = duration(queue_.front());
}

void Motion::set_feed_override(int percent) { set_override(feed_override_, percent); }
void Motion::set_rapid_override(int percent) { set_override(rapid_override_, percent); }

Joints Motion::position() const {
  if (!running_) return at_;
  const Joints& to = queue_.front().target;
  const double f = fraction();
  const auto between = [f](double a, double b) { return a + (b - a) * f; };
  return {between(at_.x, to.x), between(at_.y, to.y), between(at_.z, to.z), between(at_.a, to.a),
          between(at_.c, to.c)};
}

double Motion::speed() const {
  if (!running_ || held_ || duration_ <= 0.0) return 0.0;
  const Joints& to = queue_.front().target;
  return length({to.x - at_.x, to.y - at_.y, to.z - at_.z}) / duration_ * 60.0;
}

std::optional<std::string> Motion::outside(const Joints& target) const {
  const MachineModel& m = machine_;
  if (auto x = outside_travel('X', target.x, m.x.min, m.x.max)) return x;
  if (auto y = outside_travel('Y', target.y, m.y.min, m.y.max)) return y;
  if (auto z = outside_travel('Z', target.z, m.z.min, m.z.max)) return z;
  if (auto a = outside_travel(m.tilt.letter, target.a, m.tilt.min, m.tilt.max)) return a;
  return outside_travel(m.rotary.letter, target.c, m.rotary.min, m.rotary.max);
}

void Motion::start_next() {
  if (running_ || held_ || queue_.empty()) return;
  const Block& block = queue_.front();
  running_ = true;
  start_ = since_ = now_;
  fraction_ = 0.0;
  duration_ = duration(block);
  if (block.op == Op::kRapid || block.op == Op::kFeed) in_program_ = true;
}

void Motion::finish() {
  account();
  const Block block = queue_.front();
  queue_.pop_front();
  running_ = false;
  if (block.op == Op::kRapid || block.op == Op::kFeed) at_ = block.target;
  ++totals_.blocks;
  idle_since_ = now_;
  if (block.op == Op::kMCode) {
    if (block.m_code == 3 || block.m_code == 4) spindle_ = block.spindle;
    if (block.m_code == 5) spindle_ = 0.0;
    if (block.m_code == 2 || block.m_code == 30) {
      spindle_ = 0.0;
      in_program_ = false;
      ++totals_.programs;
    }
  }
  TraceRow row{totals_.blocks, block, start_, now_, forward_by_frames(machine_, setup_, at_)};
  row.command.target = at_;
  if (block.op == Op::kMCode && block.m_code == 0) hold();
  sink_(row);
  start_next();
}

/// Brings fraction_ and the busy time up to now.
void Motion::account() {
  if (!running_ || held_) return;
  totals_.busy += now_ - since_;
  fraction_ = fraction();
  since_ = now_;
}

double Motion::fraction() const {
  if (held_) return fraction_;
  return duration_ > 0.0 ? std::min(1.0, fraction_ + (now_ - since_) / duration_) : 1.0;
}

double Motion::duration(const Block& block) const {
  if (block.op == Op::kDwell) return block.feed;
  if (block.op == Op::kMCode) return 0.0;
  const Joints& to = block.target;
  const MachineModel& m = machine_;
  const double fastest =
      std::max({axis_time(to.x - at_.x, m.x.velocity), axis_time(to.y - at_.y, m.y.velocity),
                axis_time(to.z - at_.z, m.z.velocity), axis_time(to.a - at_.a, m.tilt.velocity),
                axis_time(to.c - at_.c, m.rotary.velocity)});
  if (block.op == Op::kRapid) return fastest * 100.0 / rapid_override_;
  double programmed = 60.0 / block.feed;
  if (!block.inverse_time) {
    // As Grbl and LinuxCNC count it: X Y Z alone; degrees only where nothing else moves.
    const double way = length({to.x - at_.x, to.y - at_.y, to.z - at_.z});
    programmed *= way > 0.0 ? way : std::hypot(to.a - at_.a, to.c - at_.c);
  }
  return std::max(programmed * 100.0 / feed_override_, fastest);
}

}  // namespace tiltfeed::sim
