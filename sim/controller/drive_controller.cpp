#include "sim/controller/drive_controller.h"

#include <algorithm>

namespace tiltfeed::sim {
namespace {

// Bits of the status register.
constexpr std::uint16_t kAlarmBit = 1, kMovingBit = 4;

double* axis_of(Joints& joints, std::size_t axis) {
  return std::array<double*, 5>{&joints.x, &joints.y, &joints.z, &joints.a, &joints.c}[axis];
}

}  // namespace

DriveController::DriveController(const MachineModel& machine, const DriveOptions& options, Motion::Sink sink)
    : options_(options), motion_(machine, {}, 1, std::move(sink)) {}

Access DriveController::write(std::uint16_t address, std::span<const std::uint16_t> words) {
  if (address == options_.stop && words.size() == 1) {
    if (words[0] != options_.stop_value) return Access::kIllegalValue;
    waiting_.reset();
    motion_.stop();
    return Access::kOk;
  }
  if (address != options_.block || words.size() != options_.words) return Access::kIllegalAddress;
  if (words.back() != options_.trigger || alarm_) return Access::kOk;
  Block block;
  block.op = Op::kFeed;
  block.feed = words[static_cast<std::size_t>(options_.feed_place)];
  block.target = motion_.position();
  for (std::size_t axis = 0; axis < options_.place.size(); ++axis) {
    if (options_.place[axis] < 0) continue;
    const auto at = static_cast<std::size_t>(options_.place[axis]);
    const auto counts =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(words[at]) << 16 | words[at + 1]);
    *axis_of(block.target, axis) = counts / options_.counts;
  }
  ++moves_;
  replaced_ += waiting_ || !motion_.idle();
  waiting_ = block;
  begins_ = now() + options_.reaction;
  advance(now());
  return Access::kOk;
}

Access DriveController::read(std::uint16_t address, std::span<std::uint16_t> words) const {
  if (address != options_.status || words.size() != 1) return Access::kIllegalAddress;
  words[0] = static_cast<std::uint16_t>((alarm_ ? kAlarmBit : 0) | (motion_.idle() ? 0 : kMovingBit));
  return Access::kOk;
}

void DriveController::advance(double now) {
  if (waiting_ && begins_ <= now) {
    motion_.advance(std::max(begins_, motion_.now()));
    motion_.stop();
    motion_.push(*waiting_);
    waiting_.reset();
  }
  motion_.advance(now);
}

}  // namespace tiltfeed::sim
