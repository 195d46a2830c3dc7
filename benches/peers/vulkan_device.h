/* Vulkan 1.3 without a window: the device, memory, buffers, images, and commands that are waited for.
 *
 * VK_ICD_FILENAMES names the driver's manifest to the Vulkan loader. */
#ifndef PEERS_VULKAN_DEVICE_H
#define PEERS_VULKAN_DEVICE_H

#include "common.h"
#include <vulkan/vulkan.h>

static VkPhysicalDevice adapter;
static VkDevice device;
static VkQueue queue;
static VkCommandPool command_pool;
static VkFence finished;

static inline void need(VkResult result, const char *what) {
    if (result == VK_SUCCESS) return;
    fprintf(stderr, "cannot have %s: VkResult %d\n", what, result);
    exit(1);
}

/* Opens the loader's first device, which must have the driver `driver`, for drawing with OpenGL's range of depth. */
static inline void open_device(VkDriverId driver) {
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo wanted = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    VkInstance instance;
    need(vkCreateInstance(&wanted, NULL, &instance), "a Vulkan driver (VK_ICD_FILENAMES)");
    uint32_t count = 1;
    VkResult listed = vkEnumeratePhysicalDevices(instance, &count, &adapter);
    need(listed == VK_INCOMPLETE ? VK_SUCCESS : listed, "a list of devices");
    if (count == 0) must(NULL, "a Vulkan device");

    VkPhysicalDeviceDriverProperties about = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &about};
    vkGetPhysicalDeviceProperties2(adapter, &properties);
    uint32_t api = properties.properties.apiVersion, version = properties.properties.driverVersion;
    fprintf(stderr, "%s, driver %u.%u.%u, Vulkan %u.%u.%u\n", properties.properties.deviceName,
            VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version), VK_API_VERSION_PATCH(version),
            VK_API_VERSION_MAJOR(api), VK_API_VERSION_MINOR(api), VK_API_VERSION_PATCH(api));
    if (about.driverID != driver) must(NULL, "the peer's own driver");

    static const char *const extensions[] = {VK_EXT_DEPTH_CLIP_CONTROL_EXTENSION_NAME};
    VkPhysicalDeviceDepthClipControlFeaturesEXT clip = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_CLIP_CONTROL_FEATURES_EXT, .depthClipControl = VK_TRUE};
    VkPhysicalDeviceVulkan13Features features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, &clip,
                                                 .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE};
    static const float priority = 1;
    VkDeviceQueueCreateInfo queues = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1,
                                      .pQueuePriorities = &priority};
    VkDeviceCreateInfo made = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features, .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queues, .enabledExtensionCount = 1,
                               .ppEnabledExtensionNames = extensions};
    need(vkCreateDevice(adapter, &made, NULL, &device), "a device with dynamic rendering and depth clip control");
    vkGetDeviceQueue(device, 0, 0, &queue);
    VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    need(vkCreateCommandPool(device, &pool, NULL, &command_pool), "a command pool");
    VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    need(vkCreateFence(device, &fence, NULL, &finished), "a fence");
}

/* Returns memory that the processor can write and read. */
static inline VkDeviceMemory host_memory(VkMemoryRequirements wanted) {
    enum { KIND = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT };
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(adapter, &memory);
    uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           (!(wanted.memoryTypeBits >> type & 1) || (memory.memoryTypes[type].propertyFlags & KIND) != KIND))
        type++;
    if (type == memory.memoryTypeCount) must(NULL, "memory of the host");
    VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, NULL, wanted.size, type};
    VkDeviceMemory made;
    need(vkAllocateMemory(device, &info, NULL, &made), "memory");
    return made;
}

typedef struct {
    VkBuffer name;
    void *bytes;
} Buffer;

/* Returns a buffer, filled with `data` where that is not NULL. */
static inline Buffer buffer(VkBufferUsageFlags usage, const void *data, size_t size) {
    VkBufferCreateInfo info = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    Buffer made;
    need(vkCreateBuffer(device, &info, NULL, &made.name), "a buffer");
    VkMemoryRequirements wanted;
    vkGetBufferMemoryRequirements(device, made.name, &wanted);
    VkDeviceMemory memory = host_memory(wanted);
    need(vkBindBufferMemory(device, made.name, memory, 0), "a buffer's memory");
    need(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &made.bytes), "a buffer's bytes");
    if (data) memcpy(made.bytes, data, size);
    return made;
}

typedef struct {
    VkImage name;
    VkImageView view;
    VkImageAspectFlags aspect;
    uint32_t levels;
} Image;

static inline Image image(VkFormat format, VkImageAspectFlags aspect, VkImageUsageFlags usage, uint32_t width,
                          uint32_t height, uint32_t levels) {
    VkImageCreateInfo info = {VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, .imageType = VK_IMAGE_TYPE_2D, .format = format,
                              .extent = {width, height, 1}, .mipLevels = levels, .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT, .tiling = VK_IMAGE_TILING_OPTIMAL, .usage = usage};
    Image made = {.aspect = aspect, .levels = levels};
    need(vkCreateImage(device, &info, NULL, &made.name), "an image");
    VkMemoryRequirements wanted;
    vkGetImageMemoryRequirements(device, made.name, &wanted);
    need(vkBindImageMemory(device, made.name, host_memory(wanted), 0), "an image's memory");
    VkImageViewCreateInfo view = {VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, .image = made.name,
                                  .viewType = VK_IMAGE_VIEW_TYPE_2D, .format = format,
                                  .subresourceRange = {aspect, 0, levels, 0, 1}};
    need(vkCreateImageView(device, &view, NULL, &made.view), "an image's view");
    return made;
}

/* Gives all of an image the layout `after` once everything before has been done; `before` may be UNDEFINED. */
static inline void change_layout(VkCommandBuffer commands, Image image, VkImageLayout before, VkImageLayout after) {
    enum { ALL = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT };
    VkImageMemoryBarrier2 barrier = {VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2, NULL,
                                     VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, ALL,
                                     VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, ALL, before, after,
                                     .image = image.name, .subresourceRange = {image.aspect, 0, image.levels, 0, 1}};
    VkDependencyInfo info = {VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1,
                             .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &info);
}

/* Returns a command buffer that may be recorded, and played any number of times. */
static inline VkCommandBuffer begin_commands(void) {
    VkCommandBufferAllocateInfo info = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, command_pool,
                                        VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer commands;
    need(vkAllocateCommandBuffers(device, &info, &commands), "a command buffer");
    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    need(vkBeginCommandBuffer(commands, &begin), "a recording");
    return commands;
}

/* Plays recorded commands, and returns when all their work is done. */
static inline void play(VkCommandBuffer commands) {
    VkSubmitInfo info = {VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    need(vkResetFences(device, 1, &finished), "a fence");
    need(vkQueueSubmit(queue, 1, &info, finished), "a queue");
    need(vkWaitForFences(device, 1, &finished, VK_TRUE, UINT64_MAX), "an end of the work");
}

static inline void end_and_play(VkCommandBuffer commands) {
    need(vkEndCommandBuffer(commands), "recorded commands");
    play(commands);
    vkFreeCommandBuffers(device, command_pool, 1, &commands);
}

#endif
