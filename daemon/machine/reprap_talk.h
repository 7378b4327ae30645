#pragma once
// A conversation with a RepRap firmware (Marlin) that no run is on: one numbered line at a time, each with
// its answer.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/protocol/reprap_reply.h"
#include "daemon/wire/axis_values.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// M114 prints two decimals.
inline constexpr double kRepRapRounding = 0.005;
/// Told where the firmware said "start" when the wire was opened.
inline constexpr const char* kRestartedText =
    "the firmware has restarted when its port was opened: its place is not homed";

struct RepRapAnswer {
  std::vector<std::string> said;  ///< what came before the ok, a line each, printable
  std::string refusal;            ///< an error, an unknown command; empty: taken
};

/// Properties: every line has a number and a checksum; a number is sent again only as it was, and only where
/// the firmware asks for it or is silent; what proves a stand or a place is asked after all of that.
class RepRapTalk {
 public:
  /// `stopped`: the operator wants no more; what waits then ends with kCancelled.
  RepRapTalk(Link& wire, Clock& clock, std::function<bool()> stopped = {});

  /// One line and its answer. `patience`: seconds without a word; "busy" is one. Errors: kLink; kCancelled,
  /// with the line still in work.
  Result<RepRapAnswer> ask(const std::string& line, double patience = 10.0);
  /// The same; a refusal is an error (kLink), with what to do.
  Result<RepRapAnswer> obey(const std::string& line, double patience = 10.0);
  /// After all that was sent has run (M400), where the axes are (M114), program coordinates.
  Result<AxisValues> place();
  /// Has all that was sent run within so long? Errors: kLink, kCancelled.
  Result<bool> stands_within(double seconds);
  /// M410, at once, where the firmware has an emergency parser; else it brakes nothing. Then the place.
  Result<AxisValues> quick_stop();
  /// Numbers agreed, firmware named. Errors: kLink.
  Result<void> settle();

  const std::string& firmware() const { return firmware_; }  ///< its name; empty: not settled
  bool emergency() const { return emergency_; }              ///< M410 acts at once
  bool restarted() const { return restarted_; }

 private:
  Result<void> turn();
  Result<RepRapAnswer> exchange(const std::string& line, double patience, bool quick);
  bool stopped() const { return stopped_ && stopped_(); }
  bool take_line(std::string& line);

  Link& wire_;
  Clock& clock_;
  std::function<bool()> stopped_;
  std::string out_, in_, firmware_;
  std::uint64_t number_ = 1;  // of the next line
  bool settled_ = false, emergency_ = false, restarted_ = false;
};

}  // namespace tiltfeed::daemon
