#include "desk/service/held_jog.h"

namespace tiltfeed::desk {

void HeldJog::begin(std::uint64_t owner, Time now) {
  owner_ = owner;
  beat_ = now;
  let_go_ = over_ = false;
}

bool HeldJog::beat(std::uint64_t owner, Time now) {
  // A beat that comes late does not bring a jog back: the hand was off the key.
  if (owner_ != owner || owner == 0 || over_ || let_go_ || now >= due()) return false;
  beat_ = now;
  return true;
}

void HeldJog::let_go(std::uint64_t owner) {
  if (owner_ == owner) let_go_ = true;
}

bool HeldJog::is_due(Time now) {
  if (owner_ == 0 || over_ || (!let_go_ && now < due())) return false;
  return over_ = true;
}

}  // namespace tiltfeed::desk
