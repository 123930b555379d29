#pragma once

#include <cstdint>

#include "libfem/materials/softening.hpp"

namespace palpate::fem {

inline constexpr int kElementNodes = 10, kElementPoints = 4;
inline constexpr int kElementBlocks =
    kElementNodes * (kElementNodes + 1) / 2;  ///< node pairs a >= b
inline constexpr int kPointStride = 4;        ///< doubles from a point in memory to the next

/// Eight elements of one material. Index order is slowest first; the last one is the lane.
/// gradient: dN_a/dX_j, [point][node][j] [1/m]. weight: rest volume of the point [m^3], 0 on an
/// idle lane and on a point of another material. constants: [point][constant], `constant_count`
/// each. mode: see unit_constant, [point] [m^-1.5]. averaged: see averaged_share.
/// max_pressure_Pa: bound on the averaged pressure where the stiffness multiplies it by the second
/// derivative of J; infinite for the exact stiffness. geometric_scale: factor of all that carries
/// the second derivative of J, see the law's evaluate(); 1 for the exact stiffness. stiffening,
/// held: of a step in time (M14a), [point][xx, yy, zz, xy, xz, yz] [Pa]; kernels of slow motion
/// read neither. softening, peak: of a material that softens (M54b), [point] [Pa].
struct CellBatch {
  const Pack* gradient;
  const Pack* weight;
  const Pack* constants;
  const Pack* mode;
  int constant_count;
  double averaged;
  double max_pressure_Pa, geometric_scale;
  double stiffening = 1;
  const Pack* held = nullptr;
  Softening softening = {};
  const Pack* peak = nullptr;
};

/// The highest derivative of the energy that is wanted.
enum class Want { energy, force, stiffness };

/// Integrals over eight elements. energy [J]; min_J over their points; force: dE/du_a, [node][i]
/// [N]; stiffness: d2E/du_a du_b for a >= b, block a(a+1)/2 + b, 3 x 3 row major [N/m].
struct CellResult {
  Pack energy;
  Pack min_J;
  Pack force[3 * kElementNodes];
  Pack stiffness[9 * kElementBlocks];
};

/// Energy of an element (M14)
///   sum w (W(F) - a U(J)) + a sum w U(theta),   theta the mean of J,
/// over its points, U the law's part of W that carries the bulk modulus, a the averaged share. With
/// a = 1 it is the Hu-Washizu form with constant dilatation and pressure, eliminated within the
/// element (Simo, Taylor and Pister 1985, doi:10.1016/0045-7825(85)90033-7). Force and stiffness
/// are exact derivatives. displacement: [node][i] [m]. At geometric_scale 0 the stiffness is
/// positive definite where theta < e and the rest of the law is. integrate: see Want. gather and
/// scatter go between the kernels' [node][i] and rows of kPointStride doubles, the last one zero;
/// points: row of each lane, [node][lane]. Scatter adds.
struct CellKernels {
  void (*gather)(const double* rows, const std::int32_t* points, Pack* displacement);
  void (*scatter)(const Pack* force, const std::int32_t* points, double* rows);
  void (*integrate[3])(const CellBatch&, const LawKernels&, const Pack* displacement, CellResult&);
};

/// The history that a step depends on: none, stresses in time, or the largest energies.
enum class Remembers { nothing, time, peak };

/// Kernels for an instruction set; results have the same bits on all of them.
CellKernels cell_kernels(Remembers history, InstructionSet set);

}  // namespace palpate::fem
