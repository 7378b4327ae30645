#pragma once
// What a machine profile says about the wire beside its address: the section `wire` of the profile file.
// Every key: config/machines/generic-ac.yaml.

#include <array>
#include <cstdint>

namespace tiltfeed::config {

/// Where the ring of a Modbus controller lies and how it counts. Addresses are 0-based holding registers.
struct RingMap {
  std::uint16_t identity = 0x0000, window = 0x0100, mailbox = 0x0180, status = 0x0200, positions = 0x0220,
                heartbeat = 0x0240;
  bool low_word_first = false;  ///< of 32-bit values
  int linear_exponent = -1;     ///< a position word counts 10^-exponent mm; -1: as the identity says
  int rotary_exponent = -1;     ///< likewise degrees
  double watchdog = 1.0;        ///< s without a heartbeat after which the controller holds
};

/// Where a plain drive has the position of one axis.
struct DriveAxis {
  int word = -1;           ///< of the written block: the first of two; -1: this drive does not move the axis
  double counts = 1000.0;  ///< per mm or degree; below 0: the drive counts the other way
};

/// A plain Modbus drive: one write sets where to and how fast, its last word sets the axes off, and one
/// register says that they move. Addresses are 0-based holding registers, `*_word` places in the write.
struct DriveMap {
  std::uint16_t block = 0x6200;  ///< first register of the write
  int words = 8;                 ///< of the write; those that nothing names are 0
  bool low_word_first = false;   ///< of positions
  int mode_word = 0, mode = 1;   ///< absolute positioning; a word of -1: none
  std::array<DriveAxis, 5> axes{DriveAxis{1, 1000.0}, {}, {}, {}, {}};  ///< X Y Z tilt rotary
  int feed_word = 3;
  double feed_counts = 1.0;  ///< per mm/min; per degree/min where only rotary axes move
  double rapid = 3000.0;     ///< mm/min of G0
  int acceleration_word = 4, acceleration = 100, deceleration_word = 5, deceleration = 100;
  int trigger = 0x0010;  ///< last word of the write
  std::uint16_t status = 0x1003;
  int moving_mask = 4, moving_value = 4;  ///< it moves while (status and mask) is the value
  int fault_mask = 1;                     ///< it is in alarm while any of these is set
  double settle = 0.02;                   ///< s after a write before `status` is believed
  std::uint16_t stop = 0x6002;
  int stop_value = 0x0040;  ///< what `stop` gets: brake, forget the move
};

enum class Parity : std::uint8_t { kNone, kEven, kOdd };
enum class FlowControl : std::uint8_t { kNone, kXonXoff, kRtsCts };
enum class EndOfBlock : std::uint8_t { kLf, kCrLf, kCr, kLfCrCr };

/// How a CNC control wants a program on its serial port (drip feed).
struct DripFormat {
  int data_bits = 7;
  Parity parity = Parity::kEven;
  int stop_bits = 2;
  FlowControl flow = FlowControl::kXonXoff;
  EndOfBlock end_of_block = EndOfBlock::kLf;
  int leader = 0, trailer = 0;   ///< NUL bytes before the first and after the last byte
  bool percent = true;           ///< % before and after the program
  bool wait_for_start = true;    ///< nothing is sent before the control's DC1
  char xon = 0x11, xoff = 0x13;  ///< DC1 and DC3, unless the control uses others
};

/// How far the axes may be reported off a program's way before the run is held: their resolution, and what
/// their drives follow late.
struct PositionTolerance {
  double mm = 0.1, deg = 0.1;
};

/// Who changes the tool in the middle of a program.
enum class ToolChanges : std::uint8_t {
  kGuided,   ///< the operator: the change is kept back, the machine is parked and led back
  kControl,  ///< the control: it is sent the change as it stands in the program
};

/// Everything above, and what a Grbl or RepRap controller does not tell by itself.
struct LinkProfile {
  RingMap ring;
  DriveMap drive;
  DripFormat drip;
  PositionTolerance position;
  int reprap_window = 0;      ///< unanswered lines; 0: by its M115, else 1
  bool line_numbers = false;  ///< N words for grblHAL's Ln: feedback
  ToolChanges tool_changes = ToolChanges::kGuided;
  double tool_length_tolerance = 0.1;  ///< mm that a mounted tool may be longer or shorter than the program's
  bool check = false;                  ///< let a Grbl controller read the program first ($C)
};

class Section;
class Description;

/// Its section `drive`: complains of words that lie outside the write or on one another.
DriveMap read_drive(const Section& wire);
void describe(const DriveMap& drive, Description& out);

/// Reads the section `wire` of a machine profile, which may be absent. Complaints go to the section.
LinkProfile read_link_profile(const Section& root);
void describe(const LinkProfile& profile, Description& out);

}  // namespace tiltfeed::config
