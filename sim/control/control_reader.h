#pragma once
// Program text of every dialect as its control executes it: blocks with every modal value filled in. A reader
// of its own, which shares nothing with the post that wrote the text. What it takes is in
// sim/control/README.md.

#include <cstdint>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "sim/control/control_words.h"
#include "sim/control/move_frames.h"
#include "sim/control/plane_words.h"
#include "sim/gcode/gcode_reader.h"

namespace tiltfeed::sim {

/// A block, and what its words mean.
struct ControlBlock {
  Block block;         ///< `line` is that of the text, from 1
  bool tcp = false;    ///< X Y Z of the target are the tip's in the part's frame
  bool fresh = false;  ///< where it begins is not known: it only states where the axes are
};

/// Places in machine coordinates (G53, G28, SUPA, M91) are not known in the program's: a Z there is taken as
/// the upper end of its travel, any other axis is unknown until the program states it again. Motion blocks
/// begin with the one that makes all five places known.
/// An arc is given in straight pieces (sim/gcode/arc_way.h), all but the last of which go on.
/// In a tilted plane the rotaries stand, and blocks are given as the slides go: there and in the plane the
/// ways are straight and as long.
class ControlReader {
 public:
  ControlReader(const config::MachineProfile& machine, const Setup& setup);

  /// Appends the blocks of a line, in the order of execution. Errors: kInput: what is not understood: it is
  /// refused and not passed over, but for the lines of the profile's own (start, end, clamps).
  /// A retract that the profile gives goes as that machine needs it: at a feed, or without a motion word.
  Result<void> read_line(std::string_view line, std::vector<ControlBlock>& blocks);
  /// Another tool is in the spindle from here on. Requires: TCP is off, and no tilted plane is in force.
  void use(const Setup& setup) { frames_ = MoveFrames(model_, setup); }
  bool ended() const { return ended_; }
  std::uint32_t lines() const { return lines_; }

 private:
  using Wrong = std::optional<std::string>;
  Wrong read(std::string_view line, std::vector<ControlBlock>& blocks);
  bool own_line(std::string_view line) const;
  bool whole_line(std::string_view line, Wrong& wrong, std::vector<ControlBlock>& blocks);
  Wrong tool_call(std::string_view line, std::vector<ControlBlock>& blocks);
  Wrong codes(const ControlWords& words);
  bool posts(int code) const;
  Wrong one_code(int tenths);
  Wrong other_unit(bool inches) const;
  Wrong names(const ControlWords& words);
  Wrong letters(const ControlWords& words) const;
  Wrong alone(const ControlWords& words) const;
  Wrong machine_codes(const ControlWords& words, std::vector<ControlBlock>& blocks);
  Wrong dwell(const ControlWords& words, std::vector<ControlBlock>& blocks);
  Wrong motion(const ControlWords& words, std::vector<ControlBlock>& blocks);
  Wrong to_machine_place(const ControlWords& words, std::vector<ControlBlock>& blocks);
  Wrong half_turn(const Joints& from) const;
  Wrong table_away() const;
  double turned(const RotaryAxis& axis, double at, WordWay way, double word) const;
  Wrong set_tcp(bool on);
  Wrong plane_line(std::string_view line);
  Wrong planes(const ControlWords& words);
  Wrong begin_plane(const ReadPlane& plane, bool at_once);
  Wrong turn_to_plane();
  Wrong plane_place(const ControlWords& words);
  // Arcs.
  bool selects_plane(int tenths) const;
  Wrong centre_words(const ControlWords& words) const;
  bool take_pole(const ControlWords& words);
  Joints arc_words() const;
  Wrong put_arc(const ControlWords& words, const Joints& start, std::vector<ControlBlock>& blocks);
  /// A block, or one of the pieces of an arc.
  void put(std::vector<ControlBlock>& blocks, bool rapid, int pieces = 1, bool goes_on = false);
  void put_code(std::vector<ControlBlock>& blocks, int code);
  bool tnc() const {
    return dialect_ == config::Dialect::kHeidenhain || dialect_ == config::Dialect::kHeidenhainIso;
  }
  bool whole() const { return known_[0] && known_[1] && known_[2] && known_[3] && known_[4]; }

  config::Dialect dialect_;
  double unit_;         ///< of the linear words, mm
  bool counts_points_;  ///< numbers without a point are thousandths
  MachineModel model_;
  MoveFrames frames_;
  std::vector<std::string> own_lines_;
  std::string own_retract_;
  std::string room_;
  std::uint32_t lines_ = 0;
  int percents_ = 0;
  bool retract_ = false;  ///< the line is the profile's own retract
  bool posted_ = false;   ///< the header of a posted program was read
  bool ended_ = false, rapid_ = true, motion_known_ = false, inverse_ = false, tcp_ = false,
       relative_ = false, shortest_ = false, exact_ = false, fresh_ = true, off_path_ = false;
  double feed_ = 0.0, spindle_ = 0.0;
  bool slides_ = false;  ///< the block has a word of X, Y or Z: F is of the unit a minute, not of degrees
  int selected_ = kToolNotSaid, tool_ = kToolNotSaid;
  Joints at_;
  std::array<bool, 5> known_{};
  int arc_ = 0;                                ///< 2 or 3: G2 or G3 is in force
  int arc_plane_ = 17;                         ///< of arcs: G17, G18 or G19
  std::array<std::optional<double>, 2> pole_;  ///< a Heidenhain's centre of arcs, X and Y
  int angle_decimals_;                         ///< that the profile prints at least
  struct Plane {
    ReadPlane told;
    bool turned = false;     ///< X Y Z are in it
    std::optional<Vec3> at;  ///< the words in it; none: as the slides stand
  };
  std::optional<Plane> plane_;
};

/// A whole program, as read_program does it.
Result<void> read_control_program(std::istream& in, const std::string& name, ControlReader& reader,
                                  const std::function<void(const ControlBlock&)>& take);

}  // namespace tiltfeed::sim
