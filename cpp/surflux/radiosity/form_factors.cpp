#include "surflux/radiosity/form_factors.h"

#include "surflux/radiosity/closure.h"
#include "surflux/radiosity/exchange.h"

namespace surflux {

Hemispheres form_factors(const Scene& scene, const FormFactorOptions& options, double* out,
                         const StageProgress& progress) {
    const Tracer tracer(scene);
    ExchangeOptions pairs;
    pairs.epsilon = options.epsilon;
    Exchange exchange =
        exchange_of_all_pairs(scene, options.visibility ? &tracer : nullptr, pairs, options.seed, progress("exchange"));
    Hemispheres hemispheres;
    if (options.visibility) {
        hemispheres = measure_hemispheres(scene, tracer, options.rays, options.seed, progress("hemispheres"));
        close(exchange, hemispheres, progress("closure"));
    }
    exchange.form_factors(out);
    return hemispheres;
}

}  // namespace surflux
