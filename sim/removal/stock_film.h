#pragma once
// The stock as it becomes less, for people to see: how far up and down coarse lines have material, at equal
// spans of time.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/removal/dexels.h"

namespace tiltfeed::sim {

class StockFilm {
 public:
  static constexpr std::size_t kFrames = 41;
  static constexpr double kMostLines = 256.0;  ///< on a side
  static constexpr std::uint16_t kNothing = 0;

  /// The distance of lines for a stock of that box and cell, mm.
  static double cell_for(const pathgen::Box& box, int axis, double cell);

  /// `lines`: the whole stock, `cell` apart; the film runs from `begin` to `end`, s.
  StockFilm(Dexels lines, double cell, double begin, double end);

  /// The body takes its material from `time` on. Requires: times ascend.
  void take(const SweptBody& body, double time);
  /// The frames that nothing was cut in since.
  void finish();

  /// What is left of them.
  const Dexels& lines() const { return lines_; }
  int axis() const { return lines_.axis(); }
  double cell() const { return cell_; }
  double begin() const { return begin_; }
  double end() const { return end_; }
  /// Lines along the two other coordinates, in the order of x, y and z.
  std::array<std::uint32_t, 2> size() const { return size_; }
  /// Of the first line, mm.
  std::array<double, 2> first() const { return first_; }
  /// Along the axis: what the heights 1 and 65535 mean, mm.
  std::array<double, 2> span() const { return span_; }
  /// By frame: the upper ends of all lines, row by row, then the lower ends; kNothing: the line is empty.
  const std::vector<std::vector<std::uint16_t>>& frames() const { return frames_; }

 private:
  void snap();
  double due() const;
  std::uint16_t height(double mm) const;

  Dexels lines_;
  double cell_, begin_, end_;
  std::array<std::uint32_t, 2> size_{};
  std::array<double, 2> first_{}, span_{};
  std::vector<std::vector<std::uint16_t>> frames_;
};

}  // namespace tiltfeed::sim
