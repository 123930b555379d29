#include "libfit/certify/devices.hpp"

namespace palpate::certify {

double least_damping_Ns_m(double stiffness_N_m, double rate_Hz, double virtual_damping_Ns_m) {
  return 0.5 * stiffness_N_m / rate_Hz + virtual_damping_Ns_m;  // (M23)
}

DeviceVerdict judge(const Device& device, double stiffness_N_m, double force_N) {
  DeviceVerdict out{device};
  out.force_fits = device.max_force_N == 0 || force_N <= device.max_force_N;
  out.stiffness_fits = device.max_stiffness_N_m == 0 || stiffness_N_m <= device.max_stiffness_N_m;
  out.resolution_fits = device.friction_N == 0 || device.resolution_m == 0 ||
                        0.5 * stiffness_N_m * device.resolution_m <= device.friction_N;  // (M24)
  return out;
}

}  // namespace palpate::certify
