#include "desk/session/seat.h"

namespace tiltfeed::desk {

void Seat::take(std::uint64_t session, Time now) {
  owner_ = session;
  seen_ = now;
  asking_ = 0;
}

bool Seat::ask(std::uint64_t session, Time now) {
  if (session == 0) return false;
  const bool unanswered = asking_ == session && is_unanswered(now);
  if (owner_ == 0 || owner_ == session || is_lost(now) || unanswered) {
    const std::uint64_t asks = asking_;
    const Time since = asked_;
    take(session, now);
    if (asks != 0 && asks != session) asking_ = asks, asked_ = since;  // now of the new owner
    return true;
  }
  if (asking_ == 0) asking_ = session, asked_ = now;
  return false;
}

void Seat::give(std::uint64_t session, Time now) {
  if (!has(session)) return;
  take(asking_, now);
}

void Seat::keep(std::uint64_t session) {
  if (has(session)) asking_ = 0;
}

void Seat::leave(std::uint64_t session) {
  if (asking_ == session) asking_ = 0;
  if (has(session)) owner_ = 0;
}

void Seat::beat(std::uint64_t session, Time now) {
  if (has(session)) seen_ = now;
}

}  // namespace tiltfeed::desk
