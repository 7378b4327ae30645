#pragma once
// The rapids between the cuts of a path, and other ways for them: higher along the tool, the turn of the axis
// before or behind the way across.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed::daemon {

/// When the axis turns.
enum class LinkTurn : std::uint8_t {
  kOnTheWay,  ///< as planned, while the tip goes across
  kBehind,    ///< over the next cut, the tip held
  kBefore,    ///< over the last cut, the tip held
};

struct LinkChoice {
  double higher = 0.0;  ///< along the tool axis, mm
  LinkTurn turn = LinkTurn::kOnTheWay;
  /// Off the cut and to it along its axis not as a rapid, for which bodies are to be further apart.
  bool at_feed = false;
  /// Between both cuts the tool is taken off to the end of the machine's Z: behind the way off the last cut a
  /// stretch of the program ends, and the next begins before the way to the next cut.
  bool at_retract = false;
};

/// In the order in which they are tried. The first is the planned way.
inline constexpr std::array<LinkChoice, 16> kLinkChoices{{{0.0, LinkTurn::kOnTheWay},
                                                          {10.0, LinkTurn::kOnTheWay},
                                                          {25.0, LinkTurn::kOnTheWay, true},
                                                          {50.0, LinkTurn::kOnTheWay},
                                                          {50.0, LinkTurn::kBehind},
                                                          {50.0, LinkTurn::kBefore},
                                                          {80.0, LinkTurn::kOnTheWay, true},
                                                          {120.0, LinkTurn::kOnTheWay, true},
                                                          {120.0, LinkTurn::kBehind, true},
                                                          {120.0, LinkTurn::kBefore, true},
                                                          {180.0, LinkTurn::kOnTheWay, true},
                                                          {250.0, LinkTurn::kOnTheWay, true},
                                                          {250.0, LinkTurn::kBehind, true},
                                                          {250.0, LinkTurn::kBefore, true},
                                                          {0.0, LinkTurn::kOnTheWay, false, true},
                                                          {50.0, LinkTurn::kOnTheWay, true, true}}};

/// From the first rapid behind a cut to the last one before the next: moves from `first` to before `last`.
struct LinkWay {
  std::size_t first = 0, last = 0;
  /// All between both cuts: leads and plunges, too.
  std::size_t begin = 0, end = 0;

  bool has(std::size_t move) const { return move >= begin && move < end; }
};

/// The links of a path in their order: first the way to the first cut, last the way from the last one. Either
/// may be empty. Properties: 1 no cut is in a link, every rapid is. 2 with_links() leaves their number as it
/// is.
std::vector<LinkWay> link_ways(const ToolPath& path);

/// Whether a choice makes another way than those before it in kLinkChoices: a way to the first cut, from the
/// last one, or between two of one axis has no turn; only one between two cuts has a retract.
bool differs(const ToolPath& path, std::size_t link, std::size_t choice);

/// The path with its links as chosen, by index into kLinkChoices. Properties: 1 the cuts, their order and
/// their feeds are as they were. 2 A link begins and ends along the axes of the cuts beside it.
/// `begins`: the moves with which stretches of the program begin behind a retract, rising.
/// Requires: a choice for each of link_ways(), one with a retract between two cuts only.
ToolPath with_links(const ToolPath& path, const std::vector<std::size_t>& choices,
                    std::vector<std::size_t>* begins = nullptr);

/// What rapids and the feeds between them measure, mm of the tip.
double rapid_length(const ToolPath& path);

}  // namespace tiltfeed::daemon
