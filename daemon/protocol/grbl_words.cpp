#include "daemon/protocol/grbl_words.h"

#include <charconv>

namespace tiltfeed::daemon {

namespace {

struct Meaning {
  int code;
  const char *what, *remedy;
};

// 1 to 38 are those of Grbl 1.1, the others grblHAL's.
constexpr Meaning kErrors[] = {
    {1, "a word does not begin with a letter", "correct the line"},
    {2, "a word has no number, or one that cannot be read", "correct the line"},
    {3, "the controller does not know this $ command", "`$` alone lists those that it has"},
    {4, "a value below zero where none may be", "correct the line"},
    {5, "homing is switched off", "switch it on ($22) where the machine has limit switches"},
    {6, "the step pulse is too short", "2 microseconds or more ($0)"},
    {7, "the stored settings could not be read and are the defaults now",
     "restore them: tiltfeed machine settings restore FILE"},
    {8, "this command needs an idle controller", "wait, or lead it out of its state: tiltfeed reset"},
    {9, "locked by an alarm or a jog", "home the machine or unlock it; a jog: wait for its end"},
    {10, "soft limits need homing", "switch homing on first ($22)"},
    {11, "the line is longer than the controller takes", "shorten it"},
    {12, "steps would come faster than the controller can make them",
     "lower the rate ($110...) or the steps ($100...)"},
    {13, "the safety door is open", "close it"},
    {14, "the start-up line is too long to be stored", "shorten it"},
    {15, "the jog would leave the machine's travel", "jog less far"},
    {16, "the jog line has a word that is none of a jog's", "axes, F, G20, G21, G90, G91, G53 only"},
    {17, "laser mode needs a PWM output", "switch it off ($32)"},
    {18, "the reset input is on", "release it"},
    {19, "a value must be above zero", "correct the line"},
    {20, "a code that this controller does not have", "post the program for its dialect"},
    {21, "two codes of one modal group in a line", "put them into two lines"},
    {22, "no feed has been set", "give an F word; under G93 each line needs its own"},
    {23, "a whole number is expected", "correct the line"},
    {24, "two codes that want the axis words of the line", "put them into two lines"},
    {25, "a word twice in a line", "correct the line"},
    {26, "axis words are missing", "name the axes"},
    {27, "the line number is out of range", "post without N words"},
    {28, "a word that the code needs is missing", "correct the line"},
    {29, "this controller does not have that work offset", "use G54 to G59"},
    {30, "G53 goes with G0 and G1 only", "correct the line"},
    {31, "axis words that no code of the line uses", "correct the line"},
    {32, "an arc without a word of its plane", "post without arcs"},
    {33, "the target is not possible", "an arc's centre, or a probe that would not move: correct the line"},
    {34, "the arc's radius does not fit", "post without arcs"},
    {35, "an arc without I, J or K of its plane", "post without arcs"},
    {36, "words that no code of the line uses", "correct the line"},
    {37, "G43.1 offsets the tool axis only", "correct the line"},
    {38, "there is no such tool number", "correct the T word"},
    {39, "a value is out of range", "correct the line"},
    {40, "not while a tool change is pending", "end the tool change first"},
    {41, "the spindle does not turn", "switch it on before this motion"},
    {42, "threading needs the plane ZX", "select G18"},
    {43, "the feed is above the axis's rate", "lower F"},
    {44, "the spindle speed is out of its range", "correct S ($30, $31)"},
    {45, "a limit switch is pressed: only homing is possible",
     "home the machine, or move the axis off by hand"},
    {46, "the machine has to be homed first", "tiltfeed machine home"},
    {47, "the controller does not know which tool is in the spindle", "tell it: M61 Q and the number"},
    {48, "two values contradict each other", "correct the line"},
    {49, "the self-test at power-on failed",
     "switch the controller off and on; look at its motors and inputs"},
    {50, "the emergency stop is pressed", "release it, then reset"},
    {51, "a motor driver reports a fault", "look at the drivers, then switch off and on"},
    {52, "the setting's value is out of range", "give another"},
    {53, "this setting is not available on this board", "leave it out"},
    {54, "the retract place is below the hole", "correct the cycle"},
    {55, "two squared axes cannot home at once", "change the homing phases ($44...)"},
    {56, "this work offset is locked", "unlock it ($486)"},
    {57, "a % where none may be", "correct the file"},
    {58, "there is no such port", "correct the P word"},
    {60, "the memory card cannot be mounted", "look at the card"},
    {61, "the file cannot be read", "look at the card"},
    {62, "the folder cannot be opened", "look at the card"},
    {63, "there is no such folder", "look at the name"},
    {64, "no memory card is mounted", "mount it: $FM"},
    {65, "no file system is mounted", "mount it: $FM"},
    {66, "the file system is read-only", "write elsewhere"},
    {70, "Bluetooth did not start", "switch the controller off and on"},
    {71, "an unknown operation in an expression", "correct the line"},
    {72, "a division by zero in an expression", "correct the line"},
    {73, "an argument out of range in an expression", "correct the line"},
    {74, "an argument that the operation does not take", "correct the line"},
    {75, "an expression that cannot be read", "correct the line"},
    {76, "an expression without a finite result", "correct the line"},
    {77, "a password is needed", "log in at the controller"},
    {78, "access is denied", "log in with more rights"},
    {79, "not while a critical event lasts", "clear the emergency stop or the fault first"},
    {80, "flow control outside a macro", "correct the line"},
    {81, "an unknown flow statement", "correct the line"},
    {82, "flow statements too deeply nested", "correct the macro"},
    {83, "no memory for the flow statement", "correct the macro"},
    {84, "the file cannot be opened", "look at its name"},
    {85, "formatting failed", "look at the card"},
    {86, "the port cannot be used so", "correct the P word"},
    {87, "a tool is in the spindle", "take it out first"},
    {88, "no tool is in the spindle", "put one in"},
    {89, "the file cannot be deleted", "look at the card"},
    {90, "cutter compensation is on already", "G40 first"},
    {91, "not while cutter compensation is on", "G40 first"},
    {92, "cutter compensation does not fit this move", "post the cutter's centre"},
    {253, "a macro raised an error of its own", "look at the macro"},
};

// 1 to 9 are those of Grbl 1.1, too; its 10 is grblHAL's 15.
constexpr Meaning kAlarms[] = {
    {1, "a limit switch was hit", "the position is lost: reset, move off the switch, home"},
    {2, "the target is beyond the travel", "the position is kept: reset, unlock, correct program or offset"},
    {3, "reset while the axes moved", "the position is lost: home"},
    {4, "the probe was touching (or not connected) before it moved",
     "look at probe and cable ($6 inverts its input), unlock, probe again"},
    {5, "the probe touched nothing on its way", "unlock, begin nearer or go further"},
    {6, "homing was ended by a reset", "home again"},
    {7, "homing was ended by the safety door", "close it, home again"},
    {8, "homing did not come off the limit switch", "longer pull-off ($27); look at the switch"},
    {9, "homing did not find the limit switch",
     "look at the switch and its direction ($23), longer travel ($130...)"},
    {10, "the emergency stop was pressed", "release it, reset, home where the axes may have slipped"},
    {11, "the machine has to be homed before it moves", "tiltfeed machine home"},
    {12, "a limit switch is pressed", "move the axis off by hand, or home"},
    {13, "the probe touched while it was not probing", "move it off, then unlock"},
    {14, "the spindle did not reach its speed", "look at the spindle and its drive, reset"},
    {15, "homing did not find the second switch of a squared axis", "look at the switch, home again"},
    {16, "the self-test at power-on failed", "switch the controller off and on"},
    {17, "a motor driver reports a fault", "look at the drivers, reset, home"},
    {18, "homing is not set up", "settings $22 and $44 to $49"},
    {19, "the spindle's Modbus does not answer", "look at its cable and drive, reset"},
    {20, "an input or output module does not answer", "look at its cable, switch off and on"},
    {21, "the settings' memory does not work", "restore them; where it comes again the board is bad"},
    {22, "a buffer ran over", "reset; a sender sent more than the controller has room for"},
};

struct Setting {
  int number;
  const char *name, *unit;
};

constexpr Setting kSettings[] = {
    {0, "step pulse time", "us"},
    {1, "step idle delay, 255: motors stay on", "ms"},
    {2, "step pulse invert", "axes"},
    {3, "step direction invert", "axes"},
    {4, "stepper enable invert", "axes"},
    {5, "limit inputs invert", "axes"},
    {6, "probe input invert", ""},
    {8, "ganged axes direction invert", "axes"},
    {9, "spindle PWM options", ""},
    {10, "status report options", ""},
    {11, "junction deviation", "mm"},
    {12, "arc tolerance", "mm"},
    {13, "report in inches", ""},
    {14, "control inputs invert", ""},
    {15, "coolant outputs invert", ""},
    {16, "spindle outputs invert", ""},
    {17, "control inputs pull-up off", ""},
    {18, "limit inputs pull-up off", "axes"},
    {19, "probe input pull-up off", ""},
    {20, "soft limits", ""},
    {21, "hard limits", ""},
    {22, "homing", ""},
    {23, "homing direction invert", "axes"},
    {24, "homing rate to locate the switch", "mm/min"},
    {25, "homing rate to search the switch", "mm/min"},
    {26, "homing debounce", "ms"},
    {27, "homing pull-off", "mm"},
    {28, "G73 retract", "mm"},
    {29, "step pulse delay", "us"},
    {30, "spindle speed, highest", "1/min"},
    {31, "spindle speed, lowest", "1/min"},
    {32, "mode: 0 mill, 1 laser, 2 lathe", ""},
    {33, "spindle PWM frequency", "Hz"},
    {34, "spindle PWM when off", "%"},
    {35, "spindle PWM, lowest", "%"},
    {36, "spindle PWM, highest", "%"},
    {37, "motors that stay on", "axes"},
    {38, "spindle encoder pulses a turn", ""},
    {39, "one-byte commands of Grbl 1.1 in text", ""},
    {40, "jogs limited to the travel", ""},
    {41, "parking at the door", ""},
    {42, "parking axis", ""},
    {43, "homing passes", ""},
    {44, "homing, first axes", "axes"},
    {45, "homing, second axes", "axes"},
    {46, "homing, third axes", "axes"},
    {47, "homing, fourth axes", "axes"},
    {48, "homing, fifth axes", "axes"},
    {49, "homing, sixth axes", "axes"},
    {50, "jog rate, step", "mm/min"},
    {51, "jog rate, slow", "mm/min"},
    {52, "jog rate, fast", "mm/min"},
    {53, "jog way, step", "mm"},
    {54, "jog way, slow", "mm"},
    {55, "jog way, fast", "mm"},
    {56, "parking pull-out way", "mm"},
    {57, "parking pull-out rate", "mm/min"},
    {58, "parking place", "mm"},
    {59, "parking rate", "mm/min"},
    {60, "overrides back to 100 % at the program's end", ""},
    {61, "safety door options", ""},
    {62, "sleep", ""},
    {63, "feed hold options", ""},
    {64, "alarm at the start", ""},
    {65, "probing options", ""},
    {340, "spindle speed tolerance", "%"},
    {341, "tool change mode", ""},
    {342, "tool change probing way", "mm"},
    {343, "tool change rate to locate", "mm/min"},
    {344, "tool change rate to search", "mm/min"},
    {345, "tool change pull-off rate", "mm/min"},
    {346, "tool change options", ""},
    {384, "G92 forgotten at power-off", ""},
    {394, "spindle on delay", "s"},
    {398, "planner", "blocks"},
    {481, "status report by itself each", "ms"},
    {486, "work offsets locked", ""},
};

struct AxisSetting {
  int first;
  const char *name, *unit;
};
constexpr AxisSetting kAxisSettings[] = {
    {100, "steps", "1/mm, 1/deg"},
    {110, "highest rate", "mm/min, deg/min"},
    {120, "acceleration", "mm/s^2, deg/s^2"},
    {130, "travel", "mm, deg"},
    {160, "backlash", "mm, deg"},
    {180, "homing rate to locate the switch", "mm/min, deg/min"},
    {190, "homing rate to search the switch", "mm/min, deg/min"},
};

struct Phrase {
  const char *said, *text;
};

constexpr Phrase kMarlin[] = {
    {"checksum mismatch", "the wire spoils bytes: look at the cable, its shield and its plugs"},
    {"No Checksum with line number", "the wire spoils bytes: look at the cable"},
    {"No Line Number with checksum", "another program sends on this wire, or it spoils bytes"},
    {"Line Number is not Last Line Number+1", "lines were lost on the wire"},
    {"Printer halted", "the firmware has stopped for good: find out why, then reset the board and home"},
    {"Thermal Runaway", "a heater or its sensor has failed: switch the machine off and look at both"},
    {"Heating failed", "a heater does not heat: switch the machine off and look at it"},
    {"MAXTEMP", "a sensor shows too much heat: switch the machine off and look at it"},
    {"MINTEMP", "a sensor is disconnected: look at its cable"},
    {"Homing Failed", "a limit switch was not found: look at it, then home again"},
    {"Probing Failed", "the probe did not touch: look at it, then home again"},
    {"Endstops hit", "a limit switch was hit: the position is lost, home"},
    {"Unknown command", "this firmware does not have the code: post the program for its dialect"},
    {"M112 Shutdown", "the emergency stop was given: reset the board and home"},
    {"KILL caused", "the kill input is on: release it, reset the board and home"},
    {"Cold extrusion", "a program for a printer"},
    {"Printer stopped", "an error has stopped it: end its cause, then `tiltfeed machine unlock`"},
};

template <std::size_t N>
std::string in_words(const char* kind, int code, const Meaning (&table)[N]) {
  if (code == 0) return kind;
  const std::string name = std::string(kind) + ":" + std::to_string(code);
  for (const Meaning& one : table)
    if (one.code == code) return name + ": " + one.what + "; " + one.remedy;
  return name;
}

}  // namespace

std::string grbl_error_text(int code) { return in_words("error", code, kErrors); }
std::string grbl_alarm_text(int code) { return in_words("ALARM", code, kAlarms); }

std::string reply_meaning(std::string_view line) {
  int code = 0;
  if (const std::size_t colon = line.find(':'); colon != line.npos)
    std::from_chars(line.data() + colon + 1, line.data() + line.size(), code);
  const std::string text = line.starts_with("ALARM") ? grbl_alarm_text(code) : grbl_error_text(code);
  const std::size_t at = text.find(": ");
  return at == text.npos ? "" : text.substr(at);
}

std::string grbl_state_text(std::string_view state, int alarm) {
  const std::string_view word = state.substr(0, state.find(':'));
  const std::string said(state);
  if (word == "Idle") return said + ": ready";
  if (word == "Run") return said + ": it executes lines";
  if (word == "Jog") return said + ": it jogs";
  if (word == "Home") return said + ": it homes";
  if (word == "Hold")
    return said + (state == "Hold:1" ? ": it brakes to a feed hold" : ": feed hold, it stands");
  if (word == "Check") return said + ": check mode, it reads and does not move; tiltfeed reset leaves it";
  if (word == "Door") return said + ": the safety door is open; close it, then resume";
  if (word == "Sleep") return said + ": asleep; tiltfeed reset wakes it";
  if (word == "Tool") return said + ": it waits for a tool change";
  if (word == "Alarm")
    return said + ": " +
           (alarm == 0 ? "it is locked; home the machine or unlock it" : grbl_alarm_text(alarm));
  return said;
}

GrblSettingName grbl_setting_name(int number, std::string_view letters) {
  for (const Setting& one : kSettings)
    if (one.number == number) return {one.name, one.unit};
  const std::string_view axes = letters.empty() ? "XYZABCUVW" : letters;
  for (const AxisSetting& one : kAxisSettings)
    if (number >= one.first && number < one.first + static_cast<int>(axes.size()))
      return {std::string(1, axes[static_cast<std::size_t>(number - one.first)]) + " " + one.name, one.unit};
  return {};
}

std::string marlin_meaning(std::string_view line) {
  for (const Phrase& one : kMarlin)
    if (line.find(one.said) != line.npos) return std::string(": ") + one.text;
  return "";
}

}  // namespace tiltfeed::daemon
