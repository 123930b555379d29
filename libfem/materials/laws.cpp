#include "libfem/materials/fung.hpp"
#include "libfem/materials/holzapfel_gasser_ogden.hpp"
#include "libfem/materials/law_row.hpp"
#include "libfem/materials/mooney_rivlin.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/ogden.hpp"
#include "libfem/materials/veronda_westmann.hpp"
#include "libfem/materials/yeoh.hpp"

namespace palpate::fem {
namespace {

// One row per law; add a law by its file and a row. The kernels of all are compiled here, which
// takes half a minute.
constexpr LawRow kLaws[] = {
    law_row<NeoHookean>(),      law_row<NeoHookeanIsochoric>(),
    law_row<MooneyRivlin>(),    law_row<Yeoh>(),
    law_row<Ogden>(),           law_row<Fung>(),
    law_row<VerondaWestmann>(), law_row<HolzapfelGasserOgden>(),
};

}  // namespace

std::span<const LawRow> material_laws() { return kLaws; }

}  // namespace palpate::fem
