#pragma once
// Who may give orders to the machine: one browser has the seat, others watch and can ask for it.

#include <chrono>
#include <cstdint>

namespace tiltfeed::desk {

/// Sessions are told apart by their numbers, from 1. Properties: at most one has the seat; it never changes
/// hands while the one that has it is there, unless that one gives it, or has not answered for kAnswer.
class Seat {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The page beats every second or two. Without a beat for so long its connection counts as lost.
  static constexpr std::chrono::seconds kLost{6};
  /// So long the one that has the seat is asked; then the one that asked may take it.
  static constexpr std::chrono::seconds kAnswer{15};

  /// Takes the seat where it is free, its owner's connection is lost, or the owner has not answered this
  /// session for kAnswer. Else it is asked for, unless another has asked. True: it has the seat.
  bool ask(std::uint64_t session, Time now);
  /// To the one that asked; free where nobody did. Nothing where it is not this session's.
  void give(std::uint64_t session, Time now);
  /// The one that asked is refused.
  void keep(std::uint64_t session);
  /// Signed out: its seat is free, its question withdrawn.
  void leave(std::uint64_t session);
  /// The page of this session is there.
  void beat(std::uint64_t session, Time now);

  std::uint64_t owner() const { return owner_; }  ///< 0: the seat is free
  bool has(std::uint64_t session) const { return session != 0 && session == owner_; }
  bool is_lost(Time now) const { return owner_ != 0 && now - seen_ >= kLost; }
  std::uint64_t asking() const { return asking_; }  ///< 0: nobody
  bool is_unanswered(Time now) const { return asking_ != 0 && now - asked_ >= kAnswer; }

 private:
  void take(std::uint64_t session, Time now);
  std::uint64_t owner_ = 0, asking_ = 0;
  Time seen_, asked_;
};

}  // namespace tiltfeed::desk
