#include "daemon/wire/link.h"

#include <charconv>
#include <optional>

namespace tiltfeed::daemon {

namespace {

constexpr int kMinBaud = 300, kMaxBaud = 4000000;
constexpr int kDefaultRtuBaud = 19200;  // the Modbus standard's default
constexpr int kDefaultDripBaud = 9600;  // what most CNC controls are set to
constexpr int kMaxUnit = 247;           // 0 is broadcast: never for motion
constexpr int kMaxPort = 65535;

tl::unexpected<Error> bad_link(std::string_view text, const std::string& why) {
  return fail(Code::kUsage, "link '" + std::string(text) + "': " + why +
                                "; examples: grbl:/dev/ttyUSB0@115200, grbl-tcp:192.168.0.5:23, "
                                "grbl-ws:192.168.0.5:80/ws, reprap:/dev/ttyACM0@250000, "
                                "dnc:/dev/ttyS0@9600, modbus-tcp:192.168.0.5:502/1, "
                                "modbus-rtu:/dev/ttyS0@19200/1");
}

std::optional<int> whole_number(std::string_view text, int min, int max) {
  int value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || value < min || value > max)
    return std::nullopt;
  return value;
}

/// Splits `rest` at the last `mark`; nothing when there is none.
std::optional<std::string_view> take_tail(std::string_view& rest, char mark) {
  const std::size_t at = rest.rfind(mark);
  if (at == rest.npos) return std::nullopt;
  const std::string_view tail = rest.substr(at + 1);
  rest = rest.substr(0, at);
  return tail;
}

Result<LinkSpec> parse_serial(std::string_view text, std::string_view rest, LinkSpec spec) {
  // The unit follows the baud rate when there is one; "/dev/ttyS0/3" would be a device file.
  if (const auto tail = take_tail(rest, '@')) {
    std::string_view baud = *tail;
    if (is_rtu(spec.kind)) {
      if (const auto unit_text = take_tail(baud, '/')) {
        const auto unit = whole_number(*unit_text, 1, kMaxUnit);
        if (!unit) return bad_link(text, "the unit must be 1 to 247");
        spec.unit = *unit;
      }
    }
    const auto value = whole_number(baud, kMinBaud, kMaxBaud);
    if (!value) return bad_link(text, "the baud rate must be 300 to 4000000");
    spec.baud = *value;
  }
  if (!rest.starts_with('/')) return bad_link(text, "the device must be a full path that starts with /");
  spec.place = rest;
  return spec;
}

Result<LinkSpec> parse_tcp(std::string_view text, std::string_view rest, LinkSpec spec) {
  const std::size_t slash = rest.find('/');
  if (spec.carrier == Carrier::kWebSocket && slash != rest.npos) {
    spec.path = rest.substr(slash);
    rest = rest.substr(0, slash);
  }
  if (const auto unit_text = take_tail(rest, '/')) {
    if (spec.kind == LinkKind::kGrbl) return bad_link(text, "only Modbus has units");
    const auto unit = whole_number(*unit_text, 1, kMaxUnit);
    if (!unit) return bad_link(text, "the unit must be 1 to 247");
    spec.unit = *unit;
  }
  const auto port_text = take_tail(rest, ':');
  if (!port_text) return bad_link(text, "the port is missing");
  const auto port = whole_number(*port_text, 1, kMaxPort);
  if (!port) return bad_link(text, "the port must be 1 to 65535");
  spec.port = *port;
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  if (rest.empty()) return bad_link(text, "the host is missing");
  spec.place = rest;
  return spec;
}

}  // namespace

Result<LinkSpec> parse_link(std::string_view text, const config::LinkProfile& profile,
                            const MachineModel* machine) {
  for (const char c : text)
    if (c <= ' ' || c > '~') return bad_link(text, "blanks and control characters have no place here");
  const std::size_t colon = text.find(':');
  if (colon == text.npos) return bad_link(text, "a kind of link and ':' are missing");
  const std::string_view kind = text.substr(0, colon), rest = text.substr(colon + 1);
  LinkSpec spec;
  spec.profile = profile;
  spec.positions = position_limits(profile.position, machine);
  if (machine != nullptr) spec.axes = numeric_axes(*machine);
  if (kind == "grbl") return parse_serial(text, rest, spec);
  if (kind == "grbl-tcp" || kind == "grbl-ws") {
    spec.carrier = kind == "grbl-ws" ? Carrier::kWebSocket : Carrier::kTcp;
    return parse_tcp(text, rest, spec);
  }
  if (kind == "reprap") {
    spec.kind = LinkKind::kRepRap;
    return parse_serial(text, rest, spec);
  }
  if (kind == "dnc") {
    spec.kind = LinkKind::kDrip;
    spec.baud = kDefaultDripBaud;
    return parse_serial(text, rest, spec);
  }
  if (kind == "modbus-rtu" || kind == "drive-rtu") {
    spec.kind = kind == "drive-rtu" ? LinkKind::kDriveRtu : LinkKind::kModbusRtu;
    spec.baud = kDefaultRtuBaud;
    return parse_serial(text, rest, spec);
  }
  if (kind == "modbus-tcp" || kind == "drive-tcp") {
    spec.kind = kind == "drive-tcp" ? LinkKind::kDriveTcp : LinkKind::kModbusTcp;
    return parse_tcp(text, rest, spec);
  }
  return bad_link(text,
                  "the kind must be grbl, grbl-tcp, grbl-ws, reprap, dnc, modbus-tcp, modbus-rtu, drive-tcp "
                  "or drive-rtu");
}

std::string describe(const LinkSpec& link) {
  const std::string host = link.place.find(':') == link.place.npos ? link.place : "[" + link.place + "]";
  switch (link.kind) {
    case LinkKind::kGrbl:
      if (link.carrier == Carrier::kWebSocket)
        return "grbl-ws:" + host + ":" + std::to_string(link.port) + (link.path == "/" ? "" : link.path);
      if (link.carrier == Carrier::kTcp) return "grbl-tcp:" + host + ":" + std::to_string(link.port);
      return "grbl:" + link.place + "@" + std::to_string(link.baud);
    case LinkKind::kRepRap:
      return "reprap:" + link.place + "@" + std::to_string(link.baud);
    case LinkKind::kDrip:
      return "dnc:" + link.place + "@" + std::to_string(link.baud);
    case LinkKind::kModbusTcp:
    case LinkKind::kDriveTcp:
      return (is_drive(link.kind) ? "drive-tcp:" : "modbus-tcp:") + host + ":" + std::to_string(link.port) +
             "/" + std::to_string(link.unit);
    case LinkKind::kModbusRtu:
    case LinkKind::kDriveRtu:
      return (is_drive(link.kind) ? "drive-rtu:" : "modbus-rtu:") + link.place + "@" +
             std::to_string(link.baud) + "/" + std::to_string(link.unit);
  }
  return "";
}

}  // namespace tiltfeed::daemon
