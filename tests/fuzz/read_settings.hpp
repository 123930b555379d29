#pragma once

#include <string>

#include "libfit/recordings/formats/importers.hpp"

namespace palpate::fuzz {

/// How a recording of a format is read, of two bytes of an input.
inline importers::ReadSettings read_settings(std::string_view format, unsigned char choice,
                                             unsigned char more) {
  importers::ReadSettings read;
  read.format = format;
  const bool names_itself = read.format == "csv" && more & 4;
  if (read.format == "matlab") {
    read.columns.time = "t_s";
    read.columns.depth = "M(:,1)";
    read.columns.force = {"M(:,2)"};
    read.units = {"s", "mm", "N", ""};
  }
  if (read.format == "csv" && !names_itself) {
    read.columns.time = choice & 1 ? "t" : "";
    if (choice & 2) {
      read.columns.position = {"x", "y", "z"};
      read.columns.force = {"fx", "fy", "fz"};
      if (choice & 4) read.columns.torque = {"tx", "ty", "tz"};
    } else {
      read.columns.depth = "z";
      read.columns.force = {"fz"};
    }
  }
  if ((read.format == "csv" && !names_itself) || read.format == "robot-palpation")
    read.units = {"s", "mm", "N", "Nmm"};
  read.is_force_on_tool = (choice & 8) != 0;
  read.max_bytes = 1 << 20;
  return read;
}

}  // namespace palpate::fuzz
