// Commands of one byte, which the Grbl firmware model obeys at once.

#include <algorithm>

#include "sim/controller/grbl_controller.h"

namespace tiltfeed::sim {
namespace {

// Real-time bytes of the Grbl family; grblHAL's 8-bit twins beside them.
constexpr unsigned char kReset = 0x18, kStatus = '?', kHold = '!', kResume = '~';
constexpr unsigned char kStatus8 = 0x80, kResume8 = 0x81, kHold8 = 0x82, kJogCancel = 0x85;
constexpr unsigned char kFeedFull = 0x90, kFeedUp10 = 0x91, kFeedDown10 = 0x92, kFeedUp1 = 0x93,
                        kFeedDown1 = 0x94;
constexpr unsigned char kRapidFull = 0x95, kRapidHalf = 0x96, kRapidQuarter = 0x97;
constexpr unsigned char kSpindleFull = 0x99, kSpindleUp10 = 0x9A, kSpindleDown10 = 0x9B, kSpindleUp1 = 0x9C,
                        kSpindleDown1 = 0x9D;
constexpr int kMinOverride = 10, kMaxOverride = 200;

}  // namespace

/// True when the byte was a real-time command; such bytes never reach the receive buffer.
bool GrblController::realtime(unsigned char byte) {
  switch (byte) {
    case kReset:
      reset();
      return true;
    case kStatus:
    case kStatus8:
      report_status();
      return true;
    case kHold:
    case kHold8:
      if (cycle_ == Cycle::kJog) {
        cancel_jog();
      } else if (alarm_ == 0 && cycle_ != Cycle::kHome) {
        motion_.hold();
      }
      return true;
    case kJogCancel:
      cancel_jog();
      return true;
    case kResume:
    case kResume8:
      if (alarm_ == 0 && cycle_ != Cycle::kCancel) motion_.resume();
      pump();
      return true;
    default:
      break;
  }
  if (byte < 0x80) return false;
  const auto spindle = [&](int percent) {
    spindle_override_ = std::clamp(percent, kMinOverride, kMaxOverride);
  };
  report_overrides_ = true;
  switch (byte) {
    case kFeedFull:
      feed_override(100);
      break;
    case kFeedUp10:
      feed_override(motion_.feed_override() + 10);
      break;
    case kFeedDown10:
      feed_override(motion_.feed_override() - 10);
      break;
    case kFeedUp1:
      feed_override(motion_.feed_override() + 1);
      break;
    case kFeedDown1:
      feed_override(motion_.feed_override() - 1);
      break;
    case kRapidFull:
      motion_.set_rapid_override(100);
      break;
    case kRapidHalf:
      motion_.set_rapid_override(50);
      break;
    case kRapidQuarter:
      motion_.set_rapid_override(25);
      break;
    case kSpindleFull:
      spindle(100);
      break;
    case kSpindleUp10:
      spindle(spindle_override_ + 10);
      break;
    case kSpindleDown10:
      spindle(spindle_override_ - 10);
      break;
    case kSpindleUp1:
      spindle(spindle_override_ + 1);
      break;
    case kSpindleDown1:
      spindle(spindle_override_ - 1);
      break;
    default:
      break;  // coolant, door: nothing to do in this machine
  }
  return true;
}

void GrblController::feed_override(int percent) {
  motion_.set_feed_override(std::clamp(percent, kMinOverride, kMaxOverride));
}

}  // namespace tiltfeed::sim
