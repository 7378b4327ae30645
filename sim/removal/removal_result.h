#pragma once
// What a removal run finds, as data.

#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/rest.h"

namespace tiltfeed::sim {

enum class TroubleKind : int {
  kGouge,       ///< a feed move cuts into the part
  kRapidPart,   ///< a rapid touches the part
  kStockHit,    ///< shank or holder touch the stock
  kRapidStock,  ///< a rapid touches the stock
};
inline constexpr std::array<const char*, 4> kTroubleNames{
    "gouge", "rapid in the part", "shank or holder in the stock", "rapid in the stock"};

/// A run of moves that do the same wrong thing; the figures are those of the worst.
struct Trouble {
  TroubleKind kind = TroubleKind::kGouge;
  ToolPart tool = ToolPart::kCutter;
  double depth = 0.0;       ///< mm
  std::uint64_t block = 0;  ///< ExecutedMove::block
  std::uint32_t line = 0;
  std::uint32_t facet = kNoFacet;  ///< of the STL file; of the part only
  Point<Part> place;               ///< of the tool tip
  double time = 0.0;               ///< s
  std::uint32_t first_move = 0, last_move = 0;
};

/// Feed moves that ask for more at the tip than any feed of the job: a block before them is missing, or F is
/// another's. The figures are those of the worst.
struct Haste {
  std::uint64_t moves = 0;  ///< how many
  double feed = 0.0;        ///< mm/min
  double ahead = 0.0;       ///< way beyond what the job's feed makes in the time that F asks for, mm
  std::uint32_t move = 0;
  Point<Part> place;  ///< of the tool tip at its end

  void take(const Haste& other);
};

/// A place where much is left on the surface that the cutter came near.
struct Leftover {
  double left = 0.0;        ///< along the facet's normal, mm
  std::uint64_t block = 0;  ///< ExecutedMove::block of the move that came nearest
  std::uint32_t line = 0;
  std::uint32_t facet = kNoFacet;  ///< of the STL file
  Point<Part> place;               ///< on the part
  double time = 0.0;               ///< s
};

/// One of the equal spans of time that the run is shown in.
struct TimeBin {
  double removed = 0.0;                          ///< mm^3
  std::array<double, 5> low, high;               ///< X Y Z tilt rotary, mm and degrees; low > high: no motion
  std::array<double, 5> speed{};                 ///< largest, mm/min and degrees/min
  double cutting = 0.0, rapid = 0.0, air = 0.0;  ///< s
};

struct Removal {
  std::vector<Trouble> troubles;  ///< of each kind the worst first, kinds in order
  Haste haste;
  std::uint64_t haste_block = 0;  ///< ExecutedMove::block of the worst
  std::uint32_t haste_line = 0;
  double haste_time = 0.0;          ///< s
  std::vector<Leftover> most_left;  ///< the most first, two cutter diameters or more from each other
  std::array<double, 4> worst{};    ///< depth by TroubleKind, mm, tolerated ones too
  Trouble gouge;                    ///< the deepest, even if it is tolerated; depth 0: none
  std::uint64_t blocks = 0;         ///< that move an axis on the path
  double seconds = 0.0, feed_seconds = 0.0, rapid_seconds = 0.0, air_seconds = 0.0;
  double feed_length = 0.0, rapid_length = 0.0;  ///< of the tip, mm
  double stock_volume = 0.0, left_volume = 0.0;  ///< mm^3
  double bin_seconds = 0.0;
  std::vector<TimeBin> bins;
  std::array<double, 5> travel_low{}, travel_high{};
  // The part's surface that the tool came within `reach` of.
  double reach = 0.0, probe_spacing = 0.0;  ///< mm
  std::uint64_t probes = 0, touched = 0;
  double area = 0.0, touched_area = 0.0;  ///< mm^2
  std::array<double, 7> excess{};         ///< percentiles kPercentiles of the material left there, mm
  double deepest = 0.0;                   ///< least of it: below 0 a gouge, mm
  Rest rest;                              ///< with RemovalOptions::rest_limit
  std::vector<float> patch_low, patch_high, patch_mean;  ///< by patch, mm; mean NaN: never touched
  double cell = 0.0;
  std::size_t bytes = 0;
};
inline constexpr std::array<double, 7> kPercentiles{1, 5, 25, 50, 75, 95, 99};

struct RemovalOptions {
  double tolerance = 0.01;   ///< depth that counts as trouble, mm
  int threads = 2;           ///< the result is the same for any number
  bool stock_known = true;   ///< what touches an unknown stock is no trouble
  double rest_limit = -1.0;  ///< find_rest() with it, mm; below 0: not
  bool stock_alone = false;  ///< what the moves do to the part is not looked at
};

}  // namespace tiltfeed::sim
