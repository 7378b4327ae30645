#pragma once
// The stations of a pass: places at which a direction of the tool axis is chosen, and the directions that
// each of them may have. (O2), (O3) in pathgen/free_axis/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_axis/direction_choice.h"
#include "pathgen/free_axis/pass_curve.h"

namespace tiltfeed::pathgen {

/// Of a direction at a station.
enum Asked : std::uint8_t { kUnknown, kClear, kStopped };

struct Station {
  double way = 0.0;  ///< its place on the pass, mm
  ClPoint point;
  Vec3 wished;  ///< unit
  bool wish_admitted = false;
  /// The candidates are directions so near to the wish, rad; 0: the wish alone.
  double window = 0.0;
  /// Those that were found not to be admissible are taken out. None: no direction is admissible.
  AxisCandidates candidates;
  std::vector<Vec3> between;        ///< further directions, of a station put in: between its neighbours'
  std::vector<std::uint8_t> asked;  ///< of each direction of the grid, what is known; empty: nothing
  Vec3 chosen;                      ///< unit; where there are candidates
  bool changed = true;              ///< since the last choice, or put in
  bool coarse = true;               ///< the candidates are not yet those round the chosen one
};

class Stations {
 public:
  /// All must outlive the object.
  Stations(const PassCurve& curve, const Admissibility& admissible, const FreeAxis& wish,
           DirectionQuery& query);

  /// (O3) For every station with an admissible direction the cheapest sequence's. A candidate is held against
  /// the part only when a sequence wants it.
  void choose();
  /// Stations more at these places (mm), between others; they and their neighbours have candidates.
  void insert(const std::vector<double>& ways);

  const std::vector<Station>& stations() const { return stations_; }
  /// A place on the pass as a station, with nothing asked.
  Station place(double way) const;
  /// Of the pass for which the station speaks, mm.
  double share(std::size_t i) const;
  double scale() const { return scale_; }        ///< over which a turn costs as much as a departure, mm
  double max_turn() const { return max_turn_; }  ///< rad/mm

 private:
  void find_windows();
  std::vector<double> needed(const std::vector<Vec3>& nearest) const;
  Vec3 nearest_clear(Station& s);
  void open_about(std::vector<double> needs);
  bool look_further();
  void open(std::size_t i, double window);
  void narrow(std::size_t i);
  void start(Station& s) const;
  void take(Station& s, std::uint32_t direction);
  std::vector<Vec3> between(std::size_t i) const;
  void price(std::size_t i);
  void settle();
  void settle(std::size_t first, std::size_t last);
  void settle_between(std::size_t first, std::size_t last);
  void sift(std::size_t i, const Vec3* before, const Vec3* after, bool all);
  bool holds(Station& s, AxisCandidate& candidate);
  void widen(std::size_t i);

  /// Turns are told to this, rad.
  static constexpr double kRounding = 1e-9;

  const PassCurve& curve_;
  const Admissibility& admissible_;
  DirectionQuery& query_;
  double max_turn_, scale_;
  std::vector<Station> stations_;
};

}  // namespace tiltfeed::pathgen
