#pragma once

// Recordings of other people's formats, made here: a Hertz press of a 5 um ball on 2 kPa after 1 um
// of free travel, its cantilever 0.05 N/m and 80 nm/V, and the way back.

#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace palpate::testing_support {

inline constexpr double kSpring_N_m = 0.05, kSensitivity_m = 80e-9, kFree_m = 1e-6;
inline constexpr int kWayRows = 400;  // of the way in, and of the way back

/// Tip travel and force of row i of 2 kWayRows.
inline double press_travel_m(int i) {
  return (i < kWayRows ? i : 2 * kWayRows - 1 - i) * (2e-6 / kWayRows);
}
inline double press_force_N(int i) {
  const double depth_m = std::max(0.0, press_travel_m(i) - kFree_m);
  return 16.0 / 9.0 * 2000 * std::sqrt(5e-6) * depth_m * std::sqrt(depth_m);
}
/// The scanner goes where the tip goes, and what the cantilever bends.
inline double press_scanner_m(int i) { return press_travel_m(i) + press_force_N(i) / kSpring_N_m; }

using Parts = std::map<std::string, std::string>;

/// A zip file of these parts, encrypted by a password that is not empty.
inline std::string zip_of(const Parts& parts, const std::string& password = "") {
  if (parts.empty()) return "PK\x05\x06" + std::string(18, '\0');
  zip_error_t failure;
  zip_source_t* store = zip_source_buffer_create(nullptr, 0, 0, &failure);
  zip_source_keep(store);
  zip_t* archive = zip_open_from_source(store, ZIP_TRUNCATE, &failure);
  for (const auto& [name, content] : parts) {
    zip_source_t* part = zip_source_buffer(archive, content.data(), content.size(), 0);
    const auto at = zip_file_add(archive, name.c_str(), part, 0);
    if (at < 0) {  // no name of a file
      zip_source_free(part);
      continue;
    }
    if (!password.empty())
      zip_file_set_encryption(archive, static_cast<zip_uint64_t>(at), ZIP_EM_AES_256,
                              password.c_str());
  }
  if (zip_get_num_entries(archive, 0) == 0) {
    zip_discard(archive);
    zip_source_free(store);
    return zip_of({});
  }
  if (zip_close(archive) != 0) throw std::runtime_error("the zip file is not written");
  zip_source_open(store);
  zip_source_seek(store, 0, SEEK_END);
  std::string bytes(static_cast<std::size_t>(zip_source_tell(store)), '\0');
  zip_source_seek(store, 0, SEEK_SET);
  zip_source_read(store, bytes.data(), bytes.size());
  zip_source_close(store);
  zip_source_free(store);
  return bytes;
}

/// A number as so many bytes, the largest first.
template <class T>
std::string big_endian(T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  std::reverse(bytes, bytes + sizeof(T));
  return {bytes, sizeof(T)};
}

/// The channels of a JPK segment: heights as 32-bit integers of 1e-14 m, deflection as 32-bit
/// integers of 1e-8 V.
inline void add_jpk_segment(Parts& parts, const std::string& folder, int segment, int first,
                            int last, const std::string& style, const std::string& header) {
  const std::string at = folder + "segments/" + std::to_string(segment) + "/";
  std::string height, bend;
  for (int i = first; i < last; ++i) {
    height += big_endian(static_cast<std::int32_t>(std::lround(-press_scanner_m(i) / 1e-14)));
    bend += big_endian(static_cast<std::int32_t>(
        std::lround(press_force_N(i) / kSpring_N_m / kSensitivity_m / 1e-8)));
  }
  parts[at + "channels/measuredHeight.dat"] = height;
  parts[at + "channels/vDeflection.dat"] = bend;
  parts[at + "segment-header.properties"] =
      "#Mon Nov 23 2026\nforce-segment-header.duration=" + std::to_string((last - first) / 400.0) +
      "\nforce-segment-header.settings.style=" + style + "\n" + header;
}

/// What a JPK header says of its channels: its own, or what the segments of a map refer to.
inline std::string jpk_channels(bool is_shared, bool has_force = true) {
  const std::string height = is_shared ? "lcd-info.0." : "channel.measuredHeight.",
                    bend = is_shared ? "lcd-info.1." : "channel.vDeflection.",
                    coded = is_shared ? "encoder." : "data.encoder.";
  const auto conversion = [](const std::string& key, const std::string& base, double factor,
                             const std::string& unit) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", factor);
    return key + "base-calibration-slot=" + base + "\n" + key + "scaling.offset=0.0\n" + key +
           "scaling.multiplier=" + text + "\n" + key + "scaling.unit.unit=" + unit + "\n";
  };
  return height + coded + "type=signedinteger\n" + height + coded + "scaling.offset=0.0\n" +
         height + coded + "scaling.multiplier=1.0E-14\n" + height +
         "conversion-set.conversions.base=absolute\n" +
         conversion(height + "conversion-set.conversion.nominal.", "absolute", 1, "m") + bend +
         coded + "type=signedinteger\n" + bend + coded + "scaling.offset=0.0\n" + bend + coded +
         "scaling.multiplier=1.0E-8\n" + bend + "conversion-set.conversions.base=volts\n" +
         conversion(bend + "conversion-set.conversion.distance.", "volts", kSensitivity_m, "m") +
         (has_force
              ? conversion(bend + "conversion-set.conversion.force.", "distance", kSpring_N_m, "N")
              : "");
}

/// One JPK curve, way in and back; with a pause of `held` repeated rows between them.
inline Parts jpk_curve(bool has_force = true, int held = 0) {
  Parts parts;
  const std::string header = jpk_channels(false, has_force);
  parts["header.properties"] =
      "type=force-scan-series\nforce-scan-series.header.position.x=1.5E-6\n"
      "force-scan-series.header.position.y=-2.0E-6\n"
      "force-scan-series.start-time=2026-11-23 13\\:57\\:09.323 +0200\n";
  add_jpk_segment(parts, "", 0, 0, kWayRows, "extend", header);
  if (held > 0) {
    add_jpk_segment(parts, "", 1, kWayRows - 1, kWayRows, "pause", header);
    const std::string at = "segments/1/";
    for (const char* channel : {"channels/measuredHeight.dat", "channels/vDeflection.dat"}) {
      const std::string one = parts[at + channel];
      for (int i = 1; i < held; ++i) parts[at + channel] += one;
    }
  }
  add_jpk_segment(parts, "", held > 0 ? 2 : 1, kWayRows, 2 * kWayRows, "retract", header);
  return parts;
}

/// A JPK map of curves side by side, 10 um apart, with the header that its curves share.
inline Parts jpk_map(int curves) {
  Parts parts;
  parts["header.properties"] = "type=force-scan-map\n";
  parts["shared-data/header.properties"] = jpk_channels(true) +
                                           "force-segment-header-info.0.settings.style=extend\n" +
                                           "force-segment-header-info.1.settings.style=retract\n";
  for (int i = 0; i < curves; ++i) {
    const std::string folder = "index/" + std::to_string(i) + "/";
    parts[folder + "header.properties"] =
        "type=force-scan-series\nforce-scan-series.header.position.x=" + std::to_string(i) +
        "0.0E-6\nforce-scan-series.header.position.y=5.0E-6\n";
    for (int segment = 0; segment < 2; ++segment)
      add_jpk_segment(parts, folder, segment, segment * kWayRows, (segment + 1) * kWayRows,
                      segment ? "retract" : "extend",
                      "channel.measuredHeight.lcd-info.*=0\nchannel.vDeflection.lcd-info.*=1\n"
                      "force-segment-header.force-segment-header-info.*=" +
                          std::to_string(segment) + "\n");
  }
  return parts;
}

/// Makes the header of an Igor wave (its first 384 bytes) add up to 0, as a reader asks.
inline void check_igor(std::string& bytes) {
  std::uint16_t sum = 0, number = 0;
  std::memset(bytes.data() + 2, 0, 2);
  for (std::size_t at = 0; at < 384; at += 2) {
    std::memcpy(&number, bytes.data() + at, 2);
    sum = static_cast<std::uint16_t>(sum + number);
  }
  sum = static_cast<std::uint16_t>(-sum);
  std::memcpy(bytes.data() + 2, &sum, 2);
}

/// An Igor wave of version 5 with columns Raw, Defl and ZSnsr.
inline std::string igor_wave() {
  std::string note =
      "SpringConstant: 0.05\rInvOLS: 8e-08\rXLVDT: 3e-06\rYLVDT: 4e-06\rIndexes: 0," +
      std::to_string(kWayRows) + "," + std::to_string(2 * kWayRows - 1) +
      "\rDirection: NaN,1,-1,\r";
  std::string bytes(384, '\0'), labels(4 * 32, '\0');
  const auto put = [&](std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  const std::int32_t rows = 2 * kWayRows;
  put(0, std::int16_t{5});
  put(4, std::int32_t{320 + 3 * 4 * rows});
  put(12, static_cast<std::int32_t>(note.size()));
  put(40, std::int32_t{4 * 32});
  put(64 + 12, std::int32_t{3 * rows});
  put(64 + 16, std::int16_t{2});
  put(64 + 68, rows);
  put(64 + 72, std::int32_t{3});
  put(64 + 84, 0.0025);  // step of rows
  bytes[64 + 152] = 's';
  const char* names[] = {"Raw", "Defl", "ZSnsr"};
  for (int c = 0; c < 3; ++c) {
    std::memcpy(labels.data() + 32 * (c + 1), names[c], std::strlen(names[c]));
    for (int i = 0; i < rows; ++i) {
      const auto value =
          static_cast<float>(c == 1 ? press_force_N(i) / kSpring_N_m : press_scanner_m(i));
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  check_igor(bytes);
  return bytes + note + labels;
}

/// A NanoScope force curve: ways in and back, each from its lowest place on, 16 bits a number.
/// has_sensor: or the ramp alone.
inline std::string nanoscope_curve(bool has_sensor = true) {
  const double height_V_per_bit = 1e-4, bend_V_per_bit = 2e-4, sensor_m_V = 2e-6;
  const double ramp_V = 10, piezo_m_V = press_scanner_m(kWayRows - 1) / ramp_V;
  std::string header =
      "\\*Force file list\r\n\\Version: 0x09010300\r\n\\*Scanner list\r\n\\@Sens. Zsens: V " +
      std::to_string(1e9 * piezo_m_V) +
      " nm/V\r\n\\*Ciao scan list\r\n\\X Offset: 3000 nm\r\n\\Y Offset: 4000 nm\r\n"
      "\\@Sens. DeflSens: V 80.00000 nm/V\r\n\\@Sens. ZsensSens: V 2000.000 nm/V\r\n"
      "\\*Ciao force list\r\n\\Scan rate: 0.5\r\n\\Forward vel.: 10\r\n\\Reverse vel.: 10\r\n";
  const std::string rows = std::to_string(kWayRows), bytes = std::to_string(4 * kWayRows);
  std::string data;
  const auto add = [&](const std::string& channel, const std::string& sensitivity,
                       double volts_per_bit, auto value) {
    char scale[80];
    std::snprintf(scale, sizeof scale, "(%.10f V/LSB)", volts_per_bit);
    header += "\\*Ciao force image list\r\n\\Data offset: " + std::to_string(8192 + data.size()) +
              "\r\n\\Data length: " + bytes + "\r\n\\Bytes/pixel: 2\r\n\\Samps/line: " + rows +
              " " + rows + "\r\n\\Spring Constant: 0.05\r\n\\@4:Image Data: S [" + channel +
              "] \"x\"\r\n\\@4:Z scale: V [" + sensitivity + "] " + scale +
              " 3.5 V\r\n\\@4:Ramp size: V [Sens. Zsens] (0.0004511699 V/LSB) 10.00000 V\r\n";
    for (int k = 0; k < 2 * kWayRows; ++k) {
      const int row = k < kWayRows ? kWayRows - 1 - k : k;  // the way in stands backwards
      const auto bits = static_cast<std::int16_t>(std::lround(value(row) / volts_per_bit));
      data.append(reinterpret_cast<const char*>(&bits), sizeof bits);
    }
  };
  add("DeflectionError", "Sens. DeflSens", bend_V_per_bit,
      [](int i) { return press_force_N(i) / kSpring_N_m / kSensitivity_m + 0.5; });
  if (has_sensor)
    add("ZSensor", "Sens. ZsensSens", height_V_per_bit,
        [&](int i) { return press_scanner_m(i) / sensor_m_V - 0.4; });
  header += "\\*File list end\r\n\x1a";
  header.resize(8192, '\0');
  return header + data;
}

/// A table as afmformats exports it.
inline std::string afmformats_table() {
  std::string text =
      "# afmformats 0.13.3\n#\n# BEGIN METADATA\n# {\n#   \"position x\": 3e-06,\n"
      "#   \"position y\": 4e-06,\n#   \"sensitivity\": 8e-08,\n#   \"spring constant\": 0.05\n"
      "# }\n# END METADATA\n#\n# force\theight (measured)\tsegment\ttime\n";
  for (int i = 0; i < 2 * kWayRows; ++i) {
    char row[128];
    std::snprintf(row, sizeof row, "%.8g\t%.8g\t%s\t%.8g\n", press_force_N(i), -press_scanner_m(i),
                  i < kWayRows ? "False" : "True", 0.0025 * i);
    text += row;
  }
  return text;
}

/// How tdms_file() is written.
struct TdmsLayout {
  bool is_interleaved = false, is_big = false;
  int segments = 1;        ///< the later ones without meta data
  bool has_scale = false;  ///< force as 16-bit integers, with a linear scale
  int groups = 1;          ///< "press 1", "press 2", ...
};

/// A TDMS file: channels `depth` (mm, f64) and `force` (N, f32 or i16 of 1e-10 N) every 2.5 ms.
inline std::string tdms_file(const TdmsLayout& layout = {}) {
  std::string out, meta;
  const auto put = [&](std::string& to, auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (layout.is_big) std::reverse(bytes, bytes + sizeof value);
    to.append(bytes, sizeof value);
  };
  const auto put_text = [&](std::string& to, const std::string& text) {
    put(to, static_cast<std::uint32_t>(text.size()));
    to += text;
  };
  const auto put_property = [&](const std::string& name, std::uint32_t type, auto value) {
    put_text(meta, name), put(meta, type);
    if constexpr (std::is_arithmetic_v<decltype(value)>)
      put(meta, value);
    else
      put_text(meta, value);
  };
  const int rows = 2 * kWayRows / layout.segments;
  put(meta, static_cast<std::uint32_t>(1 + 3 * layout.groups));
  put_text(meta, "/"), put(meta, 0xffffffffu), put(meta, 1u);
  put_property("author", 0x20, std::string("a test"));
  for (int g = 1; g <= layout.groups; ++g) {
    const std::string group = "/'press " + std::to_string(g) + "'";
    put_text(meta, group), put(meta, 0xffffffffu), put(meta, 0u);
    for (const bool is_force : {false, true}) {
      const bool has_scale = is_force && layout.has_scale;
      put_text(meta, group + (is_force ? "/'force'" : "/'depth'"));
      put(meta, 20u), put(meta, !is_force ? 10u : has_scale ? 2u : 9u), put(meta, 1u);
      put(meta, static_cast<std::uint64_t>(rows)), put(meta, has_scale ? 7u : 2u);
      put_property("wf_increment", 10, 0.0025);
      put_property("unit_string", 0x20, std::string(is_force ? "N" : "mm"));
      if (!has_scale) continue;
      put_property("NI_Scaling_Status", 0x20, std::string("unscaled"));
      put_property("NI_Number_Of_Scales", 7, 1u);
      put_property("NI_Scale[0]_Scale_Type", 0x20, std::string("Linear"));
      put_property("NI_Scale[0]_Linear_Slope", 10, 1e-10);
      put_property("NI_Scale[0]_Linear_Y_Intercept", 10, 0.0);
    }
  }
  for (int s = 0; s < layout.segments; ++s) {
    std::string raw;
    const auto depth = [&](int i) { put(raw, 1e3 * press_travel_m(s * rows + i)); };
    const auto force = [&](int i) {
      const double force_N = press_force_N(s * rows + i);
      if (layout.has_scale)
        put(raw, static_cast<std::int16_t>(std::lround(1e10 * force_N)));
      else
        put(raw, static_cast<float>(force_N));
    };
    for (int g = 0; g < layout.groups && !layout.is_interleaved; ++g) {
      for (int i = 0; i < rows; ++i) depth(i);
      for (int i = 0; i < rows; ++i) force(i);
    }
    for (int i = 0; i < rows && layout.is_interleaved; ++i)
      for (int g = 0; g < layout.groups; ++g) depth(i), force(i);
    const std::uint32_t contents = 8u | (s == 0 ? 2u | 4u : 0u) |
                                   (layout.is_interleaved ? 32u : 0u) | (layout.is_big ? 64u : 0u);
    const std::string own = s == 0 ? meta : std::string();
    out += "TDSm";
    out.append(reinterpret_cast<const char*>(&contents), 4);  // little-endian always
    put(out, 4713u);
    put(out, static_cast<std::uint64_t>(own.size() + raw.size()));
    put(out, static_cast<std::uint64_t>(own.size()));
    out += own + raw;
  }
  return out;
}

/// A MATLAB file of version 5: time `t_s` and matrix `M` of depth in mm and force in N (on the
/// body).
inline std::string matlab_file() {
  std::string bytes = "MATLAB 5.0 MAT-file, made by a test";
  bytes.resize(124, ' ');
  bytes += std::string("\x00\x01", 2) + "IM";
  const auto add = [](std::string& to, std::uint32_t kind, const void* data, std::size_t size) {
    const std::uint32_t tag[] = {kind, static_cast<std::uint32_t>(size)};
    to.append(reinterpret_cast<const char*>(tag), sizeof tag);
    to.append(static_cast<const char*>(data), size);
    to.resize((to.size() + 7) / 8 * 8, '\0');
  };
  const auto add_matrix = [&](const std::string& name, std::int32_t columns,
                              const std::vector<double>& values) {
    const std::uint32_t flags[] = {6, 0};
    const std::int32_t sizes[] = {static_cast<std::int32_t>(values.size()) / columns, columns};
    std::string body;
    add(body, 6, flags, sizeof flags), add(body, 5, sizes, sizeof sizes);
    add(body, 1, name.data(), name.size());
    add(body, 9, values.data(), values.size() * sizeof(double));
    add(bytes, 14, body.data(), body.size());
  };
  std::vector<double> time, matrix;
  for (int i = 0; i < 2 * kWayRows; ++i) time.push_back(0.0025 * i);
  for (int i = 0; i < 2 * kWayRows; ++i) matrix.push_back(1e3 * press_travel_m(i));
  for (int i = 0; i < 2 * kWayRows; ++i) matrix.push_back(press_force_N(i));
  add_matrix("t_s", 1, time), add_matrix("M", 2, matrix);
  return bytes;
}

}  // namespace palpate::testing_support
