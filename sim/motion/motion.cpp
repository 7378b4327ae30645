#include "sim/motion/motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// A word printed at the very limit must pass although the limit went through binary fractions.
constexpr double kLimitSlack = 1e-9;

// Share of the speed by which a speed that can just be braked to may miss it in floating point: a difference
// of squares keeps half the digits. The way is then short by its square, 1e-12.
constexpr double kSpeedRounding = 1e-6;

double nearest_to_zero(double min, double max) { return std::clamp(0.0, min, std::max(min, max)); }

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

Motion::Motion(MachineModel machine, Setup setup, std::size_t slots, Sink sink, MotionOptions options)
    : machine_(std::move(machine)),
      limits_(machine_),
      chain_(machine_, setup),
      slots_(slots),
      sink_(std::move(sink)),
      options_(options) {
  assert(slots_ >= 1);
  const MachineModel& m = machine_;
  at_ = {nearest_to_zero(m.x.min, m.x.max), nearest_to_zero(m.y.min, m.y.max),
         options_.begins_on_top ? m.z.max : nearest_to_zero(m.z.min, m.z.max),
         nearest_to_zero(m.tilt.min, m.tilt.max), nearest_to_zero(m.rotary.min, m.rotary.max)};
  last_ = at_;
}

void Motion::push(const Block& block) {
  assert(free_slots() > 0);
  if (queue_.empty() && in_program_ && !held_) totals_.starved += now_ - idle_since_;
  queue_.push_back(
      make_path_block(block, last_, queue_.empty() ? nullptr : &queue_.back(), limits_, options_));
  apply_overrides(queue_.back(), feed_override_, rapid_override_);
  slotless_ += !takes_slot(queue_.back());
  if (!queue_.back().stands) last_ = block.target;
  look_ahead();
  start_next();
}

void Motion::advance(double now) {
  assert(now >= now_);
  while (running_ && !standing_ && end() <= now) {
    now_ = std::max(now_, end());
    if (halts_) {
      stand();
    } else {
      finish();
    }
  }
  now_ = now;
}

std::optional<double> Motion::next_event() const {
  if (!running_ || standing_) return std::nullopt;
  return std::max(now_, end());
}

void Motion::hold() {
  if (held_) return;
  if (queue_.empty() && in_program_) totals_.starved += now_ - idle_since_;
  held_ = true;
  if (!running_) {
    standing_ = true;
    return;
  }
  replan_running();
  if (halts_ && profile_.seconds() == 0.0) stand();
}

void Motion::resume() {
  if (!held_) return;
  account();
  held_ = false;
  idle_since_ = accounted_ = now_;
  standing_ = false;
  if (running_) replan_running();
  start_next();
}

void Motion::stop() {
  quick_stop();
  accessories_ = {};
}

void Motion::quick_stop() {
  account();
  at_ = last_ = position();
  queue_.clear();
  planned_ = slotless_ = 0;
  running_ = held_ = standing_ = halts_ = in_program_ = false;
  profile_ = {};
  speed_ = 0.0;
}

/// The speeds that were foretold no longer hold, for every block.
void Motion::set_override(int& which, int percent) {
  which = percent;
  for (PathBlock& block : queue_) apply_overrides(block, feed_override_, rapid_override_);
  limit_entries(0);
  if (running_) replan_running();
}

void Motion::set_feed_override(int percent) { set_override(feed_override_, percent); }
void Motion::set_rapid_override(int percent) { set_override(rapid_override_, percent); }

Joints Motion::position() const {
  if (!running_ || queue_.front().stands) return at_;
  const Joints& to = queue_.front().command.target;
  const double f = fraction();
  const auto between = [f](double a, double b) { return a + (b - a) * f; };
  return {between(at_.x, to.x), between(at_.y, to.y), between(at_.z, to.z), between(at_.a, to.a),
          between(at_.c, to.c)};
}

double Motion::fraction() const {
  const double length = queue_.front().length;
  return length > 0.0 ? std::min(1.0, profile_.at(now_ - since_).s / length) : 1.0;
}

double Motion::speed() const {
  if (!running_ || standing_ || queue_.front().stands || queue_.front().length == 0.0) return 0.0;
  const Joints& to = queue_.front().command.target;
  const double way = length({to.x - at_.x, to.y - at_.y, to.z - at_.z});
  return way * profile_.at(now_ - since_).v / queue_.front().length * 60.0;
}

std::optional<std::string> Motion::outside(const Joints& target) const {
  const MachineModel& m = machine_;
  if (auto x = outside_travel('X', target.x, m.x.min, m.x.max)) return x;
  if (auto y = outside_travel('Y', target.y, m.y.min, m.y.max)) return y;
  if (auto z = outside_travel('Z', target.z, m.z.min, m.z.max)) return z;
  if (auto a = outside_travel(m.tilt.letter, target.a, m.tilt.min, m.tilt.max)) return a;
  return outside_travel(m.rotary.letter, target.c, m.rotary.min, m.rotary.max);
}

std::size_t Motion::window() const {
  return options_.look_ahead == 0 ? queue_.size() : std::min(queue_.size(), options_.look_ahead);
}

/// Takes what was queued into the plan, as far as the control looks.
void Motion::look_ahead() {
  if (planned_ == window()) return;
  const std::size_t known = planned_;
  planned_ = window();
  limit_entries(known);
}

/// (M4) From the end of what is planned, where the axes must be able to stand, back to the running block.
/// Stops before block `known` where nothing changes any more; 0: never.
void Motion::limit_entries(std::size_t known) {
  double exit = 0.0;
  for (std::size_t k = planned_; k-- > 1;) {
    PathBlock& block = queue_[k];
    const double entry = std::min({block.corner, queue_[k - 1].limits.speed, block.limits.speed,
                                   highest_after(exit, block.length, block.limits)});
    if (k < known && entry == block.entry) return;
    block.entry = exit = entry;
  }
  if (running_ && known > 0) replan_running();
}

/// The highest speed at the running block's end.
double Motion::exit_allowed() const { return planned_ > 1 ? queue_[1].entry : 0.0; }

void Motion::start_next() {
  if (running_ || standing_ || queue_.empty()) return;
  const PathBlock& block = queue_.front();
  running_ = true;
  start_ = accounted_ = now_;
  peaks_ = {};
  if (!block.stands) in_program_ = true;
  plan_running({0.0, block.stands ? 0.0 : speed_, 0.0}, kUnlimited);
}

/// From where the running block is now. What would come too late is left as it was planned.
void Motion::replan_running() {
  const double done = now_ - since_;
  const SpeedProfile before = profile_;
  plan_running(profile_.at(done), halts_ ? 0.0 : profile_.end().v);
  if (since_ == now_) peaks_.raise(before.peaks(done));
}

/// (M10), (M5) The rest of the running block; `exit_before`: the speed at which it would end as planned so
/// far.
void Motion::plan_running(const PathState& from, double exit_before) {
  const PathBlock& block = queue_.front();
  const PathLimits& limits = block.limits;
  if (held_) {
    const SpeedProfile brake = SpeedProfile::halt(from, limits);
    if (brake.end().s <= block.length) {
      profile_ = brake;
      since_ = now_, halts_ = true;
      return;
    }
  }
  const PathState settled = SpeedProfile::settled(from, limits);
  const double left = block.length - settled.s, allowed = held_ ? 0.0 : exit_allowed();
  if (left < 0.0) return;
  const double lowest = lowest_after(settled.v, left, limits);
  double exit = std::min(allowed, highest_after(settled.v, left, limits));
  if (lowest > allowed + kSpeedRounding * settled.v) exit = lowest;
  if (exit > std::max(allowed, exit_before)) return;
  if (const auto profile = SpeedProfile::to(from, block.length, exit, limits)) {
    profile_ = *profile;
    since_ = now_, halts_ = false;
  }
}

/// The axes have come to rest inside the running block.
void Motion::stand() {
  account();
  if (held_) {
    standing_ = true;
  } else {
    // From the end itself: the profile at this time may be a rounding short of it.
    peaks_.raise(profile_.peaks(profile_.seconds()));
    plan_running(profile_.end(), 0.0);  // resumed when it was too late to go on without coming to rest
  }
}

void Motion::switch_accessories(const Block& command) {
  const int m = command.m_code;
  if (m == 3 || m == 4) {
    accessories_.spindle = command.spindle;
    accessories_.reverse = m == 4;
  }
  if (m == 5) accessories_.spindle = 0.0;
  if (m == 7) accessories_.mist = true;
  if (m == 8) accessories_.flood = true;
  if (m == 9) accessories_.mist = accessories_.flood = false;
  if (m == 2 || m == 30) accessories_ = {};
}

void Motion::finish() {
  account();
  TraceRow row;
  row.command = queue_.front().command;
  const bool stands = queue_.front().stands;
  const double length = queue_.front().length;
  slotless_ -= !takes_slot(queue_.front());
  queue_.pop_front();
  --planned_;
  running_ = halts_ = false;
  peaks_.raise(profile_.peaks(profile_.seconds()));
  speed_ = queue_.empty() ? 0.0 : profile_.end().v;
  const Block& command = row.command;
  if (!stands) at_ = command.target;
  row.block = ++totals_.blocks;
  idle_since_ = now_;
  if (command.op == Op::kMCode) {
    switch_accessories(command);
    if (command.m_code == 2 || command.m_code == 30) {
      in_program_ = false;
      ++totals_.programs;
    }
  }
  row.start = start_, row.end = now_;
  row.command.target = at_;
  if (poses_) row.pose = chain_(at_);
  if (!stands && length > 0.0) {
    row.peak_rate = peaks_.speed / length;
    row.peak_acceleration = peaks_.acceleration / length;
  }
  if (command.op == Op::kMCode && command.m_code == 0) hold();
  if (held_ && speed_ == 0.0) standing_ = true;
  look_ahead();
  sink_(row);
  start_next();
}

/// Brings the busy time up to now.
void Motion::account() {
  if (running_ && !standing_) totals_.busy += now_ - accounted_;
  accounted_ = now_;
}

}  // namespace tiltfeed::sim
