// Passes, and the contexts that are kept for them.

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <unistd.h>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/gl/context.h"

namespace surflux::gl {

namespace {

const char* error_name(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "invalid enum";
        case GL_INVALID_VALUE:
            return "invalid value";
        case GL_INVALID_OPERATION:
            return "invalid operation";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "invalid framebuffer operation";
        case GL_OUT_OF_MEMORY:
            return "out of memory";
        default:
            return "unknown error";
    }
}

// The drivers' threads are not in a process that was forked after they were started, and a pass would wait for them
// for ever. The library, and what it keeps, is the same for all contexts: a new one does not help.
void require_own_process() {
    static std::atomic<pid_t> first_to_draw{0};
    const pid_t here = getpid();
    pid_t began = 0;
    if (!first_to_draw.compare_exchange_strong(began, here) && began != here)
        throw DeviceError(message("process ", here, " was forked from process ", began, " after that drew by OpenGL, ",
                                  "whose drivers do not survive a fork. Fork before anything is drawn, or start ",
                                  "processes by multiprocessing's \"spawn\" or \"forkserver\""));
}

// What a pass may have changed of what a new context has, and others rely on. Objects that are bound go with the pass.
void reset(const Functions& gl) {
    for (const GLenum capability : {GL_BLEND, GL_DEPTH_TEST, GL_PROGRAM_POINT_SIZE}) gl.Disable(capability);
    gl.DepthMask(GL_TRUE);
}

// A thread on which a context stays current from pass to pass.
class Worker {
public:
    explicit Worker(Api api) : api_(api), thread_([this] { work(); }) {}

    ~Worker() {
        {
            const std::lock_guard lock(mutex_);
            ends_ = true;
        }
        changed_.notify_all();
        thread_.join();
    }

    Api api() const { return api_; }

    // What the pass throws, or the making of the context, this throws; the worker is of no use any more then.
    void run(const std::function<void(const Context&)>& pass) {
        std::exception_ptr failure;
        const std::function<void()> job = with_this_limit([&] {
            try {
                if (!context_) context_.emplace(api_);
                reset(context_->gl);
                pass(*context_);
                if (const GLenum error = context_->gl.GetError(); error != GL_NO_ERROR) {
                    throw DeviceError(message("OpenGL failed on ", context_->description.renderer, " (",
                                              context_->description.api, "): ", error_name(error)));
                }
            } catch (...) {
                failure = std::current_exception();
            }
        });
        std::unique_lock lock(mutex_);
        job_ = &job;
        changed_.notify_all();
        changed_.wait(lock, [&] { return job_ == nullptr; });
        lock.unlock();
        if (failure) std::rethrow_exception(failure);
    }

private:
    void work() {
        std::unique_lock lock(mutex_);
        while (true) {
            changed_.wait(lock, [&] { return ends_ || job_ != nullptr; });
            if (job_ == nullptr) break;
            lock.unlock();
            (*job_)();
            lock.lock();
            job_ = nullptr;
            changed_.notify_all();
        }
        context_.reset();  // on the thread that it is current on
    }

    const Api api_;
    std::optional<Context> context_;
    std::mutex mutex_;
    std::condition_variable changed_;
    const std::function<void()>* job_ = nullptr;
    bool ends_ = false;
    std::thread thread_;  // last: it begins when all else is there
};

// Of workers that have nothing to do the last one. Others that passes at the same time needed end with these.
class IdleWorker {
public:
    std::unique_ptr<Worker> take(Api api) {
        std::unique_ptr<Worker> taken;
        {
            const std::lock_guard lock(mutex_);
            taken = std::move(worker_);
        }
        if (!taken || taken->api() != api) taken = std::make_unique<Worker>(api);
        return taken;
    }
    void put(std::unique_ptr<Worker> worker) {
        const std::lock_guard lock(mutex_);
        std::swap(worker_, worker);
    }

private:
    std::mutex mutex_;
    std::unique_ptr<Worker> worker_;
};

}  // namespace

void run_pass(const std::function<void(const Context&)>& pass, Api api) {
    require_own_process();
    // Never destroyed: when a process ends, drivers may be gone before it.
    static auto* const idle = new IdleWorker;
    std::unique_ptr<Worker> worker = idle->take(api);
    worker->run(pass);
    idle->put(std::move(worker));
}

Description describe(Api api) {
    Description found;
    run_pass([&](const Context& context) { found = context.description; }, api);
    return found;
}

}  // namespace surflux::gl
