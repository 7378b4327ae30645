#pragma once
// Arcs in program text: G2 and G3 with I J K, C round CC.

#include <array>
#include <optional>
#include <string>

#include "daemon/post/dialect_words.h"
#include "daemon/post/nc_program.h"
#include "daemon/post/text_language.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The radius at the end of an arc that is read differs by no more from that at its start, mm.
inline constexpr double kReadRadiusError = 0.02;

/// What of arcs stays in force from line to line.
struct ArcReader {
  int motion = 0;                             ///< 2 or 3: G2 or G3 is in force; 0: neither
  std::array<std::optional<double>, 2> pole;  ///< a Heidenhain's, X and Y, mm

  /// Why I J K cannot stand in this line; nothing: they can, or there are none.
  std::optional<std::string> misplaced(const DialectWords& words, int plane,
                                       const TextLanguage& language) const;
  /// A Heidenhain's centre, absolute. True: the line says that alone.
  bool take_pole(const DialectWords& words, const TextLanguage& language);
  /// The arc of a block. Errors: kInput: no centre, a full circle, an end beside the circle, a third axis or
  /// a rotary that moves, a radius word.
  Result<TextArc> arc(const DialectWords& words, int plane, const TextLanguage& language, const Joints& from,
                      const Joints& to) const;
};

/// The words at a share of the way of an arc: the radius grows evenly with the angle.
Joints along_arc(const TextArc& arc, const Joints& from, const Joints& to, double share);
/// How long its way is, mm.
double arc_length(const TextArc& arc, const Joints& from, const Joints& to);

}  // namespace tiltfeed::daemon
