// Names of what is left out of this OpenImageIO, image buffers and fonts, where its core mentions them: there are no
// fonts, nothing was counted, and no ImageBuf can be made whose members could be called.
#include <OpenImageIO/imagebuf.h>

#include "imageio_pvt.h"

OIIO_NAMESPACE_3_1_BEGIN

void ImageBuf::reset(const ImageSpec&, InitializePixels) {}
void* ImageBuf::localpixels() { return nullptr; }

OIIO_NAMESPACE_3_1_END

OIIO_NAMESPACE_BEGIN

namespace pvt {

int imagebuf_print_uncaught_errors(1);
int imagebuf_use_imagecache(0);
atomic_ll IB_local_mem_current;
atomic_ll IB_local_mem_peak;
std::atomic<float> IB_total_open_time(0.0f);
std::atomic<float> IB_total_image_read_time(0.0f);

static const std::vector<std::string> none;
const std::vector<std::string>& font_dirs() { return none; }
const std::vector<std::string>& font_file_list() { return none; }
const std::vector<std::string>& font_list() { return none; }
const std::vector<std::string>& font_family_list() { return none; }
const std::vector<std::string> font_style_list(string_view) { return {}; }
const std::string font_filename(string_view, string_view) { return {}; }

}  // namespace pvt

OIIO_NAMESPACE_END
